#include "rali/graph/block_cholesky.hpp"

#include <Eigen/Cholesky>

#include "rali/base/assert.hpp"

namespace rali::graph {

namespace {

using Eigen::MatrixXd;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Lower part of `update` (rows below the pivots of `child`) added to its parent's front.
void extend_add(const Supernode& child, const MatrixXd& update, MatrixXd& front) {
  const int below = static_cast<int>(child.offsets_in_parent.size());
  const int base = child.pivot_size();
  const auto size = [&](int b) {
    return child.offsets[at(child.pivots + b + 1)] - child.offsets[at(child.pivots + b)];
  };
  for (int c = 0; c < below; ++c) {
    const int from_column = child.offsets[at(child.pivots + c)] - base;
    const int to_column = child.offsets_in_parent[at(c)];
    for (int r = c; r < below; ++r) {
      const int from_row = child.offsets[at(child.pivots + r)] - base;
      front.block(child.offsets_in_parent[at(r)], to_column, size(r), size(c)) +=
          update.block(from_row, from_column, size(r), size(c));
    }
  }
}

// Gathers the rows and columns of the front's rows below the pivots from the parent's full matrix.
MatrixXd gather(const Supernode& child, const MatrixXd& parent) {
  const int base = child.pivot_size();
  const int n = child.size() - base;
  MatrixXd out(n, n);
  const int below = static_cast<int>(child.offsets_in_parent.size());
  for (int c = 0; c < below; ++c) {
    const int c_from = child.offsets[at(child.pivots + c)];
    const int c_size = child.offsets[at(child.pivots + c + 1)] - c_from;
    for (int r = 0; r < below; ++r) {
      const int r_from = child.offsets[at(child.pivots + r)];
      const int r_size = child.offsets[at(child.pivots + r + 1)] - r_from;
      out.block(r_from - base, c_from - base, r_size, c_size) = parent.block(
          child.offsets_in_parent[at(r)], child.offsets_in_parent[at(c)], r_size, c_size);
    }
  }
  return out;
}

}  // namespace

BlockCholesky::BlockCholesky(const BlockMatrix& pattern, const std::vector<int>& last,
                             bool keep_last)
    : plan_(pattern, last, keep_last), keep_last_(keep_last) {
  const std::size_t fronts = plan_.supernodes.size();
  scatter_.resize(fronts);
  children_.resize(fronts);
  panels_.resize(fronts);
  updates_.resize(fronts);
  int first = 0;
  for (const int variable : plan_.order) {
    first_at_.push_back(first);
    first += pattern.dim(variable);
  }
  for (std::size_t s = 0; s < fronts; ++s) {
    const int parent = plan_.supernodes[s].parent;
    if (parent >= 0) children_[at(parent)].push_back(static_cast<int>(s));
  }
  for (std::size_t e = 0; e < pattern.entries().size(); ++e) {
    const auto& entry = pattern.entries()[e];
    const int row = plan_.position[at(entry.row)];
    const int column = plan_.position[at(entry.column)];
    const int s = plan_.supernode_at[at(std::min(row, column))];
    const Supernode& front = plan_.supernodes[at(s)];
    const auto place = [&](int position) {
      const auto found = std::lower_bound(front.rows.begin(), front.rows.end(), position);
      RALI_ASSERT(found != front.rows.end() && *found == position);
      return front.offsets[at(static_cast<int>(found - front.rows.begin()))];
    };
    scatter_[at(s)].push_back({static_cast<int>(e), place(std::max(row, column)),
                               place(std::min(row, column)), row < column});
  }
}

void BlockCholesky::assemble(const BlockMatrix& matrix, std::size_t s, double relative,
                             double absolute, MatrixXd& front) {
  const int size = plan_.supernodes[s].size();
  front.setZero(size, size);
  for (const Scatter& put : scatter_[s]) {
    const auto block = matrix.block(matrix.entries()[at(put.entry)]);
    if (put.transposed) {
      front.block(put.row, put.column, block.cols(), block.rows()) = block.transpose();
      continue;
    }
    auto to = front.block(put.row, put.column, block.rows(), block.cols());
    to = block;
    if (put.row == put.column) {
      to.diagonal() =
          block.diagonal() * (1.0 + relative) + Eigen::VectorXd::Constant(block.rows(), absolute);
    }
  }
  for (const int child : children_[s]) {
    extend_add(plan_.supernodes[at(child)], updates_[at(child)], front);
    updates_[at(child)].resize(0, 0);
  }
}

bool BlockCholesky::factorise(const BlockMatrix& matrix, double relative, double absolute) {
  MatrixXd front;
  for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) {
    assemble(matrix, s, relative, absolute, front);
    if (keep_last_ && s + 1 == plan_.supernodes.size()) {
      schur_ = front.selfadjointView<Eigen::Lower>();
      break;
    }
    const int p = plan_.supernodes[s].pivot_size();
    const int below = plan_.supernodes[s].size() - p;
    Eigen::Ref<MatrixXd> pivots = front.topLeftCorner(p, p);
    const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(pivots);  // in place
    // The factorisation itself does not detect a NaN.
    if (llt.info() != Eigen::Success || !pivots.diagonal().allFinite()) {
      return false;
    }
    if (below > 0) {
      auto rest = front.bottomLeftCorner(below, p);
      pivots.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(rest);
      auto update = front.bottomRightCorner(below, below);
      update.selfadjointView<Eigen::Lower>().rankUpdate(rest, -1.0);
      updates_[s] = update;
    }
    panels_[s] = front.leftCols(p);
  }
  return true;
}

MatrixXd BlockCholesky::permuted(const MatrixXd& x, bool back) const {
  MatrixXd y(x.rows(), x.cols());
  for (std::size_t p = 0; p < plan_.order.size(); ++p) {
    const int variable = plan_.order[p];
    const int in_order = first_at_[p];
    const int in_matrix = plan_.unknowns[at(variable)];
    const int dim = (p + 1 < plan_.order.size() ? first_at_[p + 1] : plan_.size) - in_order;
    if (back) {
      y.middleRows(in_matrix, dim) = x.middleRows(in_order, dim);
    } else {
      y.middleRows(in_order, dim) = x.middleRows(in_matrix, dim);
    }
  }
  return y;
}

/// Fronts with a zero right side are skipped: a right side with few nonzero rows visits only the
/// path from these to the root.
void BlockCholesky::forward(MatrixXd& x) const {
  const std::size_t end = plan_.supernodes.size() - (keep_last_ ? 1 : 0);
  for (std::size_t s = 0; s < end; ++s) {
    const Supernode& front = plan_.supernodes[s];
    const int p = front.pivot_size();
    auto pivots = x.middleRows(first_at_[at(front.first)], p);
    if ((pivots.array() == 0.0).all()) continue;
    panels_[s].topRows(p).triangularView<Eigen::Lower>().solveInPlace(pivots);
    if (front.size() == p) continue;
    const MatrixXd moved = panels_[s].bottomRows(front.size() - p) * pivots;
    for (std::size_t r = at(front.pivots); r < front.rows.size(); ++r) {
      const int dim = front.offsets[r + 1] - front.offsets[r];
      x.middleRows(first_at_[at(front.rows[r])], dim) -=
          moved.middleRows(front.offsets[r] - p, dim);
    }
  }
}

void BlockCholesky::backward_front(std::size_t s, MatrixXd& x) const {
  const Supernode& front = plan_.supernodes[s];
  const int p = front.pivot_size();
  auto pivots = x.middleRows(first_at_[at(front.first)], p);
  MatrixXd below(front.size() - p, x.cols());
  for (std::size_t r = at(front.pivots); r < front.rows.size(); ++r) {
    const int dim = front.offsets[r + 1] - front.offsets[r];
    below.middleRows(front.offsets[r] - p, dim) = x.middleRows(first_at_[at(front.rows[r])], dim);
  }
  pivots.noalias() -= panels_[s].bottomRows(front.size() - p).transpose() * below;
  panels_[s].topRows(p).triangularView<Eigen::Lower>().transpose().solveInPlace(pivots);
}

void BlockCholesky::backward(MatrixXd& x) const {
  for (std::size_t s = plan_.supernodes.size(); s-- > 0;) backward_front(s, x);
}

BlockCholesky::PartialSolution::PartialSolution(const BlockCholesky& factor, const MatrixXd& right)
    : factor_(factor),
      x_(factor.permuted(right, false)),
      done_(factor.plan_.supernodes.size(), false) {
  RALI_ASSERT(!factor.keep_last_);
  factor.forward(x_);
}

/// A front depends only on those above it.
MatrixXd BlockCholesky::PartialSolution::of(int variable) {
  const Elimination& plan = factor_.plan_;
  const int position = plan.position[at(variable)];
  std::vector<int> open;
  for (int s = plan.supernode_at[at(position)]; s >= 0 && !done_[at(s)];
       s = plan.supernodes[at(s)].parent) {
    open.push_back(s);
  }
  for (auto s = open.rbegin(); s != open.rend(); ++s) {
    factor_.backward_front(at(*s), x_);
    done_[at(*s)] = true;
  }
  const Supernode& front = plan.supernodes[at(plan.supernode_at[at(position)])];
  const int k = position - front.first;
  return x_.middleRows(factor_.first_at_[at(position)],
                       front.offsets[at(k + 1)] - front.offsets[at(k)]);
}

MatrixXd BlockCholesky::solve(const MatrixXd& right) const {
  RALI_ASSERT(!keep_last_ && right.rows() == plan_.size);
  MatrixXd x = permuted(right, false);
  forward(x);
  backward(x);
  return permuted(x, true);
}

Eigen::VectorXd BlockCholesky::reduce(const Eigen::VectorXd& right) const {
  RALI_ASSERT(keep_last_ && right.size() == plan_.size);
  MatrixXd x = permuted(right, false);
  forward(x);
  return x;
}

// With the inverse Z and L of a front split in pivots P and rows R below: Z_RP = -Z_RR L_RP
// L_PP^-1, Z_PP = L_PP^-T L_PP^-1 - (L_RP L_PP^-1)^T Z_RP; Z_RR is part of the parent's Z.
std::vector<MatrixXd> BlockCholesky::inverse_diagonal() const {
  RALI_ASSERT(!keep_last_);
  std::vector<MatrixXd> diagonal(plan_.order.size());
  std::vector<MatrixXd> inverse(plan_.supernodes.size());
  std::vector<std::size_t> waiting(plan_.supernodes.size());
  for (std::size_t s = 0; s < waiting.size(); ++s) waiting[s] = children_[s].size();
  for (std::size_t s = plan_.supernodes.size(); s-- > 0;) {
    const Supernode& front = plan_.supernodes[s];
    const int p = front.pivot_size();
    const int below = front.size() - p;
    const MatrixXd unit =
        panels_[s].topRows(p).triangularView<Eigen::Lower>().solve(MatrixXd::Identity(p, p));
    MatrixXd& Z = inverse[s];
    Z.resize(front.size(), front.size());
    Z.topLeftCorner(p, p).noalias() = unit.transpose() * unit;
    if (below > 0) {
      Z.bottomRightCorner(below, below) = gather(front, inverse[at(front.parent)]);
      const MatrixXd gain = panels_[s].bottomRows(below) * unit;
      Z.bottomLeftCorner(below, p).noalias() = -Z.bottomRightCorner(below, below) * gain;
      Z.topLeftCorner(p, p).noalias() -= gain.transpose() * Z.bottomLeftCorner(below, p);
      Z.topRightCorner(p, below) = Z.bottomLeftCorner(below, p).transpose();
      if (--waiting[at(front.parent)] == 0) inverse[at(front.parent)].resize(0, 0);
    }
    for (int k = 0; k < front.pivots; ++k) {
      const int from = front.offsets[at(k)];
      const int dim = front.offsets[at(k + 1)] - from;
      diagonal[at(plan_.order[at(front.first + k)])] = Z.block(from, from, dim, dim);
    }
    if (children_[s].empty()) Z.resize(0, 0);
  }
  return diagonal;
}

std::size_t BlockCholesky::stored() const {
  std::size_t sum = 0;
  for (const Supernode& front : plan_.supernodes) {
    sum += at(front.size()) * at(front.pivot_size());
  }
  return sum;
}

}  // namespace rali::graph
