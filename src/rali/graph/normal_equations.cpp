#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

NormalEquations::NormalEquations(const Window& window, double huber_sd)
    : keyframe_columns_(window.keyframe_columns()),
      border_(window.columns() - window.keyframe_columns()) {
  // The diagonal is there even where no factor is: a keyframe that nothing holds.
  for (int k = 0; k < keyframe_columns_ / kStateDim; ++k) block(k, k).setZero();
  relinearise(window, huber_sd);
}

void NormalEquations::relinearise(const Window& window, double huber_sd) {
  for (auto& entry : blocks_) entry.second.setZero();
  border_rows_.setZero(border_, keyframe_columns_);
  corner_.setZero(border_, border_);
  gradient_.setZero(keyframe_columns_ + border_);
  cost_ = 0.0;
  for_each_factor(window, huber_sd, [this](const LinearFactor& factor) { add(factor); });
  if (window.dense.H.rows() > 0) add_prior(graph::linearise(window, window.dense));
}

StateMat& NormalEquations::block(int column, int row) {
  const auto found = blocks_.find({column, row});
  if (found != blocks_.end()) return found->second;
  has_pattern_ = false;
  return blocks_.emplace(std::pair{column, row}, StateMat::Zero()).first->second;
}

void NormalEquations::add(const LinearFactor& factor) {
  cost_ += factor.cost;
  const auto& J = factor.J;
  for (int a = 0; a < factor.block_count; ++a) {
    const auto& A = factor.blocks[static_cast<std::size_t>(a)];
    const auto Ja = J.middleCols(A.local, A.dim);
    gradient_.segment(A.column, A.dim).noalias() += Ja.transpose() * factor.r;
    const bool border_a = A.column >= keyframe_columns_;
    for (int b = 0; b < factor.block_count; ++b) {
      const auto& B = factor.blocks[static_cast<std::size_t>(b)];
      if (B.column > A.column) continue;
      const auto Jb = J.middleCols(B.local, B.dim);
      if (!border_a) {
        block(B.column / kStateDim, A.column / kStateDim).topLeftCorner(A.dim, B.dim).noalias() +=
            Ja.transpose().lazyProduct(Jb);
      } else if (B.column < keyframe_columns_) {
        border_rows_.block(A.column - keyframe_columns_, B.column, A.dim, B.dim).noalias() +=
            Ja.transpose().lazyProduct(Jb);
      } else {
        corner_.block(A.column - keyframe_columns_, B.column - keyframe_columns_, A.dim, B.dim)
            .noalias() += Ja.transpose().lazyProduct(Jb);
      }
    }
  }
}

void NormalEquations::add_prior(const LinearPrior& prior) {
  cost_ += prior.cost;
  for (const auto& A : prior.blocks) {
    gradient_.segment(A.column, A.dim) += prior.gradient.segment(A.local, A.dim);
    for (const auto& B : prior.blocks) {
      if (B.column > A.column) continue;
      const auto H = prior.H.block(A.local, B.local, A.dim, B.dim);
      if (A.column < keyframe_columns_) {
        block(B.column / kStateDim, A.column / kStateDim) += H;
      } else if (B.column < keyframe_columns_) {
        border_rows_.block(A.column - keyframe_columns_, B.column, A.dim, B.dim) += H;
      } else {
        corner_.block(A.column - keyframe_columns_, B.column - keyframe_columns_, A.dim, B.dim) +=
            H;
      }
    }
  }
}

// Lower triangle, column by column, rows growing: the order in which a compressed matrix has it.
template <class Put>
void NormalEquations::for_each_entry(const Put& put) const {
  for (auto first = blocks_.begin(); first != blocks_.end();) {
    const int column = first->first.first;
    auto last = first;
    while (last != blocks_.end() && last->first.first == column) ++last;
    for (int c = 0; c < kStateDim; ++c) {
      const int to = column * kStateDim + c;
      for (auto it = first; it != last; ++it) {
        const int row = it->first.second;
        for (int r = row == column ? c : 0; r < kStateDim; ++r) {
          put(row * kStateDim + r, to, it->second(r, c));
        }
      }
      for (int r = 0; r < border_; ++r) put(keyframe_columns_ + r, to, border_rows_(r, to));
    }
    first = last;
  }
  for (int c = 0; c < border_; ++c) {
    for (int r = c; r < border_; ++r) {
      put(keyframe_columns_ + r, keyframe_columns_ + c, corner_(r, c));
    }
  }
}

void NormalEquations::make_pattern() {
  const int n = keyframe_columns_ + border_;
  Eigen::Index count = 0;
  for_each_entry([&count](int, int, double) { ++count; });
  matrix_.resize(n, n);
  matrix_.resizeNonZeros(count);
  int* begins = matrix_.outerIndexPtr();
  int* rows = matrix_.innerIndexPtr();
  int at = 0;
  for_each_entry([&](int row, int column, double) {
    if (row == column) begins[column] = at;  // the first of its column
    rows[at++] = row;
  });
  begins[n] = at;
  ldlt_.analyzePattern(matrix_);
  has_pattern_ = true;
}

bool NormalEquations::factorise(double relative, double absolute) {
  if (!has_pattern_) make_pattern();
  double* out = matrix_.valuePtr();
  for_each_entry([&](int row, int column, double v) {
    *out++ = row == column ? v + relative * v + absolute : v;
  });
  ldlt_.factorize(matrix_);
  return ldlt_.info() == Eigen::Success && ldlt_.vectorD().minCoeff() > 0.0;
}

Eigen::VectorXd NormalEquations::solve(const Eigen::VectorXd& right) const {
  return ldlt_.solve(right);
}

}  // namespace rali::graph
