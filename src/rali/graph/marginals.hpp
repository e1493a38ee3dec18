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

/// Factors without damping but with an information of 1e-12 of each diagonal element (1e-12 of its
/// unit where there is none), so that what nothing holds gets a variance that is huge and not NaN.
/// Where even that is not enough for a positive pivot it is raised in steps.
/// @return false if none helps
template <class Equations>
[[nodiscard]] bool factorise_with_floor(Equations& equations) {
  constexpr double kFloor = 1e-12;
  constexpr double kFloorMax = 1e-6;
  constexpr double kFloorFactor = 100.0;
  for (double floor = kFloor; floor <= kFloorMax; floor *= kFloorFactor) {
    if (equations.factorise(floor, kFloor)) return true;
  }
  return false;
}

/// Covariances at the values of a window, from one factorisation of its normal equations without
/// damping. Its floor is added here only and never to the solution; if none helps, all variances
/// are infinite.
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
