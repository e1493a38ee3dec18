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

/// Who else drives in the place.
enum class Other { kNobody, kAhead, kStanding };

/// One drive through one place.
struct DriveOptions {
  std::string place = "tunnel";
  sim::Lidar lidar = sim::Lidar::kRs16;
  std::uint64_t seed = 1;
  Other other = Other::kNobody;
  int pedestrians = 4;
  double way_m = 60.0;  ///< length of the piece that is looked at; where it begins is by chance
};

/// A sweep at a keyframe of the drive, with the truth.
struct Station {
  std::shared_ptr<const sensor::LidarScan> scan;        ///< LiDAR frame, not undistorted
  geometry::SE3 T_world_body;                           ///< at the end of the sweep
  std::vector<odometry::TimedPose> sweep;               ///< true poses over the sweep
  geometry::Vec3 axis_world = geometry::Vec3::UnitX();  ///< of the route there, horizontal, unit
  double driven_m = 0.0;                                ///< since the first station
  std::vector<geometry::Vec3> others_world_m;           ///< bodies of other vehicles, mid sweep
};

using StationListener = std::function<void(const Station&, const sensor::Calibration&)>;

/// Casts a sweep every 0.5 m of the piece, every 0.125 m with a vehicle ahead. Same options: same
/// sweeps. Errors (kUsage): no such place, or too many people.
[[nodiscard]] Status drive(const DriveOptions& options, const StationListener& listener);

}  // namespace rali::degeneracy_bench
