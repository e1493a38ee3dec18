#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rali/odometry/deskew.hpp"
#include "rali/sensor/calibration.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::degeneracy_bench {

/// Other vehicles in the world.
enum class Other { kNobody, kAhead, kStanding };

/// One drive through one world.
struct DriveOptions {
  std::string place = "tunnel";
  sim::Lidar lidar = sim::Lidar::kRs16;
  std::uint64_t seed = 1;
  Other other = Other::kNobody;
  int pedestrians = 4;
  double path_m = 60.0;  ///< length of the recorded part, which starts at a random position
};

/// A scan at a keyframe of the drive, with ground truth.
struct Station {
  std::shared_ptr<const sensor::LidarScan> scan;        ///< LiDAR frame, not undistorted
  geometry::SE3 T_world_body;                           ///< at the end of the scan
  std::vector<odometry::TimedPose> poses;               ///< true poses during the scan
  geometry::Vec3 axis_world = geometry::Vec3::UnitX();  ///< of the route there, horizontal, unit
  double driven_m = 0.0;                                ///< since the first station
  std::vector<geometry::Vec3> others_world_m;           ///< bodies of other vehicles at mid scan
};

using StationListener = std::function<void(const Station&, const sensor::Calibration&)>;

/// Simulates a scan every 0.5 m of the part, every 0.125 m with a vehicle ahead. Same options: same
/// scans. Errors (kUsage): no such world, or too many people.
[[nodiscard]] Status drive(const DriveOptions& options, const StationListener& listener);

}  // namespace rali::degeneracy_bench
