#pragma once

#include <memory>
#include <span>

#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::vehicle {

struct KnownPlace;

struct PeerMaskSettings {
  bool use = true;
  double radius_m = 1.2;
  double above_m = 0.5;
  double below_m = 1.2;
  double margin_sigma = 2.0;
  double sigma_max_m = 0.7;

  template <class V>
  void visit(V& v) {
    v("use", use, "points on other vehicles of the fleet are left out");
    v("radius_m", radius_m, 0.1, 20.0, "around the other's antenna, level");
    v("above_m", above_m, 0.0, 20.0, "and so far above it");
    v("below_m", below_m, 0.0, 20.0, "and below");
    v("margin_sigma", margin_sigma, 0.0, 10.0,
      "and by so many sigmas of its place farther around it");
    v("sigma_max_m", sigma_max_m, 0.01, 10.0, "where the other stands must be known so well");
  }
};

/// A sweep without the points on other vehicles (algorithms 3.6): they are the commonest false grip
/// in a tunnel, and do not belong into a map.
/// @param T_odom_lidar at the end of the sweep
/// @param antennas_odom of vehicles whose place is known, as seen from this one
/// @return null if no point is left out
[[nodiscard]] std::shared_ptr<const sensor::LidarScan> without_peers(
    const sensor::LidarScan& scan, const geometry::SE3& T_odom_lidar,
    std::span<const KnownPlace> antennas_odom, const geometry::Vec3& up_odom,
    const PeerMaskSettings& settings);

}  // namespace rali::vehicle
