#pragma once

#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/robust/plane_fit.hpp"

namespace rali::odometry {

/// Planes of one scan by the direction in which they are seen (cells of 6 degrees).
///
/// Rings of a sparse LiDAR meet a surface two degrees apart: 10 m ahead they are metres apart on
/// the floor, and no cell of the map holds two of them until the vehicle has driven. A sensor that
/// stands would see its pitch and height by the few planes near it. By direction three rings are
/// neighbours at any distance, and what they meet is one plane or too thick to be one.
class ViewPlanes {
 public:
  /// @param points_odom of one scan, from T_odom_lidar  @param epoch of the pose (drift.hpp)
  ViewPlanes(const std::vector<geometry::Vec3>& points_odom, const geometry::SE3& T_odom_lidar,
             double epoch, const PlaneSettings& settings);

  [[nodiscard]] const std::vector<Plane>& planes() const { return planes_; }

  /// Index of the plane in the direction of a point, -1 if none.
  [[nodiscard]] int find(const geometry::Vec3& p_odom_m) const;

  /// Whether the sensor is so far from where it was that other surfaces are seen in a direction.
  [[nodiscard]] bool is_left(const geometry::SE3& T_odom_lidar) const;

 private:
  [[nodiscard]] int cell_of(const geometry::Vec3& p_odom_m) const;

  geometry::SE3 T_odom_lidar_;
  std::vector<int> plane_of_cell_;
  std::vector<Plane> planes_;
};

}  // namespace rali::odometry
