#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/deskew.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry::test {

/// Upright walls on axis-parallel lines between two horizontal planes, 3 m apart; z is 0 midway.
struct Wall {
  double x1_m, y1_m, x2_m, y2_m;
};

using Rooms = std::vector<Wall>;

/// Two rooms of 4 x 6 m and 5 x 5 m with a door of 1 m between them; a box in the first.
inline Rooms two_rooms() {
  return {{-4, -3, -4, 3}, {-4, -3, 0, -3}, {-4, 3, 0, 3}, {0, -3, 0, -0.5}, {0, 0.5, 0, 3},
          {0, -2, 5, -2},  {0, 3, 5, 3},    {5, -2, 5, 3}, {-4, 2, -3, 2},   {-3, 2, -3, 3}};
}

/// One large hall: a different place.
inline Rooms hall() { return {{-9, -7, -9, 7}, {9, -7, 9, 7}, {-9, -7, 9, -7}, {-9, 7, 9, 7}}; }

/// Horizontal distance to the first wall.
inline double distance_m(const Rooms& rooms, double x, double y, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  double nearest = 1e3;
  for (const Wall& w : rooms) {
    const bool upright = w.x1_m == w.x2_m;
    const double along = upright ? c : s;
    if (std::abs(along) < 1e-9) continue;
    const double r = (upright ? w.x1_m - x : w.y1_m - y) / along;
    const double q = upright ? y + r * s : x + r * c;
    const double from = upright ? std::min(w.y1_m, w.y2_m) : std::min(w.x1_m, w.x2_m);
    const double to = upright ? std::max(w.y1_m, w.y2_m) : std::max(w.x1_m, w.x2_m);
    if (r > 1e-6 && q >= from && q <= to) nearest = std::min(nearest, r);
  }
  return nearest;
}

/// A LiDAR scan from there: 64 rings from -42 to 42 degrees, a ray each 1.5 degrees.
inline sensor::LidarScan seen_from(const Rooms& rooms, double x, double y, double yaw_rad, Time t) {
  constexpr double kHalfHeight_m = 1.5;
  constexpr double kRadian = std::numbers::pi / 180.0;
  sensor::LidarScan scan;
  scan.t_start = t;
  scan.t_end = t;
  for (int column = 0; column < 240; ++column) {
    const double azimuth = 1.5 * kRadian * column;
    const double wall_m = distance_m(rooms, x, y, yaw_rad + azimuth);
    for (int ring = 0; ring < 64; ++ring) {
      const double slope = std::tan(kRadian * (-42.0 + 84.0 * ring / 63.0));
      const double level_m = kHalfHeight_m / std::max(1e-6, std::abs(slope));
      const double r = std::min(wall_m, level_m);
      scan.push_back(static_cast<float>(r * std::cos(azimuth)),
                     static_cast<float>(r * std::sin(azimuth)), static_cast<float>(r * slope), 0.0F,
                     0.0F, 0);
    }
  }
  return scan;
}

inline geometry::SE3 upright_pose(double x, double y, double yaw_rad) {
  return {geometry::so3_exp(yaw_rad * geometry::Vec3::UnitZ()), {x, y, 0.0}};
}

}  // namespace rali::odometry::test
