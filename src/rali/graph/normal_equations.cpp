#include "rali/graph/normal_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rali::graph {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

BlockMatrix pattern(const Window& window) {
  const BlockLayout layout(window);
  return {layout.dims, block_pairs(window, layout)};
}

void add(const LinearFactor& factor, NormalEquations::Slope& to) {
  to.cost += factor.cost;
  for (int a = 0; a < factor.block_count; ++a) {
    const auto& A = factor.blocks[at(a)];
    if (A.column < 0) continue;
    to.gradient.segment(A.column, A.dim).noalias() +=
        factor.J.middleCols(A.local, A.dim).transpose() * factor.r;
  }
}

void add(const LinearPrior& prior, NormalEquations::Slope& to) {
  to.cost += prior.cost;
  for (const auto& A : prior.blocks) {
    if (A.column < 0) continue;
    to.gradient.segment(A.column, A.dim) += prior.gradient.segment(A.local, A.dim);
  }
}

}  // namespace

BlockLayout::BlockLayout(const Window& window) : variable_at(at(window.columns()), -1) {
  int column = 0;
  const auto unknown = [&](int dim) {
    variable_at[at(column)] = static_cast<int>(dims.size());
    dims.push_back(dim);
    column += dim;
  };
  for (const KeyframeNode& keyframe : window.keyframes) {
    if (!keyframe.fixed) unknown(keyframe.dim);
  }
  for (const GlobalNode& global : window.globals) {
    globals.push_back(static_cast<int>(dims.size()));
    unknown(global.dim());
  }
}

std::vector<std::pair<int, int>> block_pairs(const Window& window, const BlockLayout& layout) {
  std::vector<std::pair<int, int>> pairs;
  std::vector<int> together;
  const auto touch = [&](int column) {
    if (column >= 0) together.push_back(layout.variable_at[at(column)]);
  };
  const auto join = [&] {
    for (std::size_t a = 0; a < together.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) pairs.emplace_back(together[a], together[b]);
    }
    together.clear();
  };
  for_each_factor(window, std::numeric_limits<double>::infinity(), [&](const LinearFactor& factor) {
    for (int b = 0; b < factor.block_count; ++b) touch(factor.blocks[at(b)].column);
    join();
  });
  for (const auto& block : window.dense.keyframes) touch(window.column(block.seq));
  for (const auto& block : window.dense.globals) touch(window.column(block.id));
  join();
  return pairs;
}

NormalEquations::NormalEquations(const Window& window, double huber_sd)
    : variable_at_(BlockLayout(window).variable_at),
      H_(pattern(window)),
      cholesky_(H_, BlockLayout(window).globals) {
  relinearise(window, huber_sd);
}

NormalEquations::NormalEquations(const Window& window, double huber_sd,
                                 const std::vector<int>& kept)
    : variable_at_(BlockLayout(window).variable_at),
      H_(pattern(window)),
      cholesky_(H_, kept, true) {
  relinearise(window, huber_sd);
}

void NormalEquations::relinearise(const Window& window, double huber_sd) {
  H_.set_zero();
  slope_.gradient.setZero(window.columns());
  slope_.cost = 0.0;
  for_each_factor(window, huber_sd, [this](const LinearFactor& factor) {
    add(factor, slope_);
    add_curvature(factor);
  });
  if (window.dense.H.rows() == 0) return;
  const LinearPrior prior = graph::linearise(window, window.dense);
  add(prior, slope_);
  add_curvature(prior);
}

NormalEquations::Slope NormalEquations::slope(const Window& window, double huber_sd) {
  Slope slope;
  slope.gradient.setZero(window.columns());
  for_each_factor(window, huber_sd, [&](const LinearFactor& factor) { add(factor, slope); });
  if (window.dense.H.rows() > 0) add(graph::linearise(window, window.dense), slope);
  return slope;
}

void NormalEquations::add_curvature(const LinearFactor& factor) {
  const auto& J = factor.J;
  for (int a = 0; a < factor.block_count; ++a) {
    const auto& A = factor.blocks[at(a)];
    if (A.column < 0) continue;
    const auto Ja = J.middleCols(A.local, A.dim);
    for (int b = 0; b < factor.block_count; ++b) {
      const auto& B = factor.blocks[at(b)];
      if (B.column < 0 || B.column > A.column) continue;
      H_.block(variable_at_[at(A.column)], variable_at_[at(B.column)])
          .topLeftCorner(A.dim, B.dim)
          .noalias() += Ja.transpose().lazyProduct(J.middleCols(B.local, B.dim));
    }
  }
}

void NormalEquations::add_curvature(const LinearPrior& prior) {
  for (const auto& A : prior.blocks) {
    if (A.column < 0) continue;
    for (const auto& B : prior.blocks) {
      if (B.column < 0 || B.column > A.column) continue;
      H_.block(variable_at_[at(A.column)], variable_at_[at(B.column)]) +=
          prior.H.block(A.local, B.local, A.dim, B.dim);
    }
  }
}

Eigen::MatrixXd NormalEquations::right_of(const LinearFactor& factor) const {
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(gradient().size(), factor.r.size());
  for (int b = 0; b < factor.block_count; ++b) {
    const auto& block = factor.blocks[at(b)];
    if (block.column < 0) continue;
    right.middleRows(block.column, block.dim) +=
        factor.J.middleCols(block.local, block.dim).transpose();
  }
  return right;
}

Eigen::MatrixXd NormalEquations::covariance(const LinearFactor& factor) const {
  BlockCholesky::PartialSolution solution(cholesky_, right_of(factor));
  const Eigen::Index rows = factor.r.size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
  for (int b = 0; b < factor.block_count; ++b) {
    const auto& block = factor.blocks[at(b)];
    if (block.column < 0) continue;
    P += factor.J.middleCols(block.local, block.dim) *
         solution.of(variable_at(block.column)).topRows(block.dim);
  }
  return 0.5 * (P + P.transpose());
}

bool factorise_with_floor(NormalEquations& equations) {
  constexpr double kFloor = 1e-12;
  constexpr double kFloorMax = 1e-6;
  constexpr double kFloorFactor = 100.0;
  for (double floor = kFloor; floor <= kFloorMax; floor *= kFloorFactor) {
    if (equations.factorise(floor, kFloor)) return true;
  }
  return false;
}

}  // namespace rali::graph
