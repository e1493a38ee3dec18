#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// An invented mine with three vehicles, for tests and demonstrations of the live page without a
/// fleet. Nothing here is measured or estimated.
namespace rali::view_demo {

struct Point {
  float x_m, y_m, z_m;
};

/// A vehicle at a moment.
struct Pose {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0, speed_mps = 0.0;
  bool at_rest = true, degenerate = false;
  std::array<double, 2> axis{};  ///< along which the LiDAR is degenerate
};

inline constexpr int kVehicles = 3;
inline constexpr double kEnd_s = 270.0;
inline constexpr double kFirstHandOver_s = 105.0, kSecondHandOver_s = 190.0;
inline constexpr double kTableMoves_s = 92.0;  ///< a loop closure corrects the gallery of v3
inline constexpr double kLostStart_s = 228.0, kLostEnd_s = 256.0;

/// Points of all walls, floors and roofs.
[[nodiscard]] std::vector<Point> mine_points();

[[nodiscard]] Pose pose_of(int vehicle, double t_s);

/// Index of the anchor, which is stationary at this time.
[[nodiscard]] int anchor_at(double t_s);

}  // namespace rali::view_demo
