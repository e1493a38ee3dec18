#pragma once

#include <memory>
#include <span>

#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::vehicle {

struct KnownLandmark;
struct ReceivedPeer;

struct PeerMaskSettings {
  bool use = true;
  double radius_m = 1.2;
  double above_m = 0.5;
  double below_m = 1.2;
  double margin_sigma = 2.0;
  double sigma_max_m = 0.7;
  double shell_m = 1.0;
  double shell_slope = 0.2;
  double shell_far_m = 25.0;
  double shell_after_s = 0.5;
  double shell_hold_s = 10.0;

  template <class V>
  void visit(V& v) {
    v("use", use, "points on other vehicles of the fleet are masked");
    v("radius_m", radius_m, 0.1, 20.0, "around the other's antenna, level");
    v("above_m", above_m, 0.0, 20.0, "and so far above it");
    v("below_m", below_m, 0.0, 20.0, "and below");
    v("margin_sigma", margin_sigma, 0.0, 10.0,
      "and by so many sigmas of its place farther around it");
    v("sigma_max_m", sigma_max_m, 0.01, 10.0, "largest sigma of the other's position");
    v("shell_m", shell_m, 0.0, 10.0,
      "otherwise, where degenerate: mask all points at the range of the other vehicle, this thick; "
      "0: nothing");
    v("shell_slope", shell_slope, 0.0, 10.0, "and so much higher or lower per metre of range");
    v("shell_far_m", shell_far_m, 0.0, 1000.0, "vehicles farther away are not masked");
    v("shell_after_s", shell_after_s, 0.0, 1e4,
      "time of degeneracy after which the shell is masked");
    v("shell_hold_s", shell_hold_s, 0.0, 1e4,
      "time after the last degenerate scan in which the shell is still masked");
  }
};

/// A scan without the points on other vehicles (algorithms 3.6). In a tunnel these points are the
/// most frequent cause of false constraints, and they do not belong in a map.
/// @param T_odom_lidar at the end of the scan
/// @param antennas_odom of vehicles of known position, with covariance relative to this vehicle
/// @param received those of unknown position: all points at their range are left out, on every side
/// @return null if no point is left out
[[nodiscard]] std::shared_ptr<const sensor::LidarScan> without_peers(
    const sensor::LidarScan& scan, const geometry::SE3& T_odom_lidar,
    const geometry::SE3& T_body_lidar, std::span<const KnownLandmark> antennas_odom,
    std::span<const ReceivedPeer> received, const geometry::Vec3& up_odom,
    const PeerMaskSettings& settings);

}  // namespace rali::vehicle
