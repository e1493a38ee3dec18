#pragma once

#include <cstdint>

#include "rali/odometry/side_filter.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::vehicle {

/// One sane range with what was known when it was judged: for those who look at it again later.
struct RangeRecord {
  std::uint64_t id = 0;  ///< running number, never used again
  Time t;
  geometry::SE3 T_odom_body;  ///< of the filter, at t
  geometry::Vec3 p_body_antenna_m = geometry::Vec3::Zero();
  double range_m = 0.0;
  double sigma_m = 0.1;   ///< of this range, raised by signal and map
  double R_m2 = 0.01;     ///< what it counts with, neighbours' common errors included
  double rate_mps = 0.0;  ///< of the range
  int place = 0;          ///< number of the place where the other antenna stands
  int pair = 0;           ///< number of the pair of antennas
  bool used = false;      ///< by the filter
};

/// A place where a peer's antenna stood, as first known.
struct PlaceRecord {
  int place = 0;
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  /// Of what was known without the ranges recorded.
  geometry::Mat3 prior_covariance_m2 = geometry::Mat3::Zero();
};

/// The bias of a pair of antennas as known before any range.
struct PairRecord {
  int pair = 0;
  double bias_m = 0.0;
  double bias_sigma_m = 0.1;
};

}  // namespace rali::vehicle
