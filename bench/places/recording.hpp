#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::recognition {

struct RecordOptions {
  sim::Scene scene = sim::Scene::kCorridor;
  std::uint64_t seed = 1;
  sim::Lidar lidar = sim::Lidar::kRs16;
  int vehicles = 2;
  int pedestrians = 0;
  double duration_s = 100.0;  ///< of all vehicles' motion
  /// The recording of one vehicle is cut into two that overlap by a fifth of its time: vehicles 0
  /// and 1, each with its own odometry.
  bool halves = false;
};

/// A keyframe of the odometry, thinned as for transmission, with ground truth.
struct Kept {
  KeyframeId id;
  geometry::SE3 T_odom_body, T_world_body, T_body_lidar;
  geometry::Vec3 up_body = geometry::Vec3::UnitZ();
  std::vector<float> x_m, y_m, z_m;
};

/// Drives the vehicles through the scene and runs the odometry of each. With a cache folder the
/// keyframes are stored there. Errors: of the simulation.
[[nodiscard]] Result<std::vector<Kept>> record(const RecordOptions& options,
                                               const std::string& cache_dir);

}  // namespace rali::recognition
