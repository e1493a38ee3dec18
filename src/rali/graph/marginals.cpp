#include "rali/graph/marginals.hpp"

#include <algorithm>
#include <limits>

namespace rali::graph {

namespace {

// A range whose own weight makes up all of its variance has nothing to be compared with.
constexpr double kShareMax = 1.0 - 1e-9;

}  // namespace

Marginals::Marginals(const Window& window, double huber_sd) : equations_(window, huber_sd) {
  solved_ = factorise_with_floor(equations_);
}

Eigen::MatrixXd Marginals::covariance(const std::vector<int>& columns) const {
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  if (!solved_) {
    P.diagonal().setConstant(std::numeric_limits<double>::infinity());
    return P;
  }
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(equations_.gradient().size());
  for (Eigen::Index c = 0; c < n; ++c) {
    unit(columns[static_cast<std::size_t>(c)]) = 1.0;
    const Eigen::VectorXd x = equations_.solve(unit);
    unit(columns[static_cast<std::size_t>(c)]) = 0.0;
    for (Eigen::Index r = 0; r < n; ++r) P(r, c) = x(columns[static_cast<std::size_t>(r)]);
  }
  return 0.5 * (P + P.transpose());
}

double Marginals::variance(const LinearFactor& row) const {
  if (!solved_) return std::numeric_limits<double>::infinity();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(equations_.gradient().size());
  for (int b = 0; b < row.block_count; ++b) {
    const auto& block = row.blocks[static_cast<std::size_t>(b)];
    right.segment(block.column, block.dim) += row.J.row(0).segment(block.local, block.dim);
  }
  return right.dot(equations_.solve(right));
}

RangePrediction predict(const Window& window, const Marginals& marginals, const RangeFactor& f) {
  LinearFactor row;
  range_residual(window, f, row);
  return {row.r(0) + f.range_m, marginals.variance(row)};
}

std::vector<RangeNis> range_nis(const Window& window, const Marginals& marginals, double huber_sd) {
  std::vector<RangeNis> all;
  LinearFactor row;
  for (const RangeFactor& f : window.ranges) {
    linearise(window, f, huber_sd, row);
    // In units of the sigma in force (loss included): share of the posterior that is the range's.
    const double share = std::min(marginals.variance(row), kShareMax);
    const double nu = row.r(0) / (1.0 - share);
    const double prediction = share / (1.0 - share);
    // Back to the nominal sigma: the loss hides what is looked for.
    range_residual(window, f, row);
    const double z = row.r(0) * std::sqrt(f.weight) / f.sigma_m;
    const double loss = z == 0.0 ? 1.0 : std::min(1.0, huber_sd / std::abs(z));
    const double variance = prediction + loss;
    all.push_back({f.id, nu * nu / variance});
  }
  return all;
}

}  // namespace rali::graph
