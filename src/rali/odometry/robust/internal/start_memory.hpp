#pragma once

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

/// The members that a replay of the start changes.
struct RobustOdometry::StartMemory {
  FilterState state, last_posterior;
  PlaneMap map;
  Drift drift;
  VehicleConstraints constraints;
  std::optional<Refusal> refusal;
  degeneracy::Axes axes;
  geometry::Mat3 lidar_known;
  std::array<bool, 3> degenerate;
  Bend bend;
  std::array<int, 3> seeing_scans;
  Time t_degenerate, t_speed_bounded;
  std::optional<Time> t_seen;
  double fastest_seen_mps, usual_fit, noise_boost;
  int scans_in_map;
  ScanSampler sampler;
};

}  // namespace rali::odometry::internal
