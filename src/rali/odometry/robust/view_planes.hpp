#pragma once

#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/robust/plane_fit.hpp"

namespace rali::odometry {

/// Planes of one scan by the direction in which they are observed (cells of 6 degrees).
///
/// Rings of a sparse LiDAR meet a surface two degrees apart. 10 m ahead they are metres apart on
/// the floor, and no map cell contains two of them until the vehicle has driven. At standstill,
/// pitch and height would depend on the few planes nearby. By direction three rings are neighbours
/// at any distance, and their points form one plane or are too thick for one.
class ViewPlanes {
 public:
  /// @param points_odom of one scan, from T_odom_lidar  @param epoch of the pose (drift.hpp)
  ViewPlanes(const std::vector<geometry::Vec3>& points_odom, const geometry::SE3& T_odom_lidar,
             double epoch, const PlaneSettings& settings);

  [[nodiscard]] const std::vector<Plane>& planes() const { return planes_; }

  /// Index of the plane in the direction of a point, -1 if none.
  [[nodiscard]] int find(const geometry::Vec3& p_odom_m) const;

  /// Whether the sensor has moved so far that other surfaces are in a direction.
  [[nodiscard]] bool is_left(const geometry::SE3& T_odom_lidar) const;

 private:
  [[nodiscard]] int cell_of(const geometry::Vec3& p_odom_m) const;

  geometry::SE3 T_odom_lidar_;
  std::vector<int> plane_of_cell_;
  std::vector<Plane> planes_;
};

}  // namespace rali::odometry
