#pragma once

#include <vector>

#include "rali/graph/normal_equations.hpp"

namespace rali::graph {

/// A range as the graph expects it without having seen it.
struct RangePrediction {
  double range_m = 0.0;      ///< bias and time offset included
  double variance_m2 = 0.0;  ///< of that, without the noise of the measurement
};

/// NIS of a range against all else in the graph.
struct RangeNis {
  std::uint64_t id = 0;
  double nis = 0.0;
};

/// Covariances at the values of a window, from one factorisation of its normal equations without
/// damping.
///
/// An information of 1e-12 of each diagonal element (1e-12 of its unit where there is none) is
/// added, here only and never to the solution: what nothing holds then has a variance that is huge
/// (hundreds of metres) but a number. Where even that is not enough for a positive pivot it is
/// raised in steps; if none helps, all variances are infinite.
class Marginals {
 public:
  Marginals(const Window& window, double huber_sd);

  /// Rows and columns of the covariance for these unknowns, in their order.
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<int>& columns) const;

  /// J P J^T of one row.
  [[nodiscard]] double variance(const LinearFactor& row) const;

 private:
  NormalEquations equations_;
  bool solved_ = false;
};

[[nodiscard]] RangePrediction predict(const Window& window, const Marginals& marginals,
                                      const RangeFactor& f);

/// Of each live range, the NIS it had if it came last: residual and variance are those that the
/// graph without this range would have predicted.
[[nodiscard]] std::vector<RangeNis> range_nis(const Window& window, const Marginals& marginals,
                                              double huber_sd);

}  // namespace rali::graph
