#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/point_grid.hpp"

namespace rali::odometry::paper {

/// Plane through the map points around a query point.
struct LocalPlane {
  geometry::Vec3 centre_odom = geometry::Vec3::Zero();  ///< mean of the neighbours [m]
  geometry::Vec3 n_odom = geometry::Vec3::Zero();       ///< unit, same side as the query's normal
  int neighbours = 0;
  double normal_variance = 0.0;  ///< of one tilt of the mean normal, from the scatter [rad^2]
};

/// Features of the keyframes, and the submap of those nearest to the vehicle.
/// Source: paper, section "Scan-to-Map Matching"; reading of the map normals: algorithms.md 2.1.
class Submap {
 public:
  /// @param radius_m neighbours of a query point are nearer than this
  /// @param normal_max_rad map points whose normal differs more from the query's are ignored
  Submap(double radius_m, double normal_max_rad, int keyframes, int kept_max);

  /// Adds the features of a keyframe, given in the body frame.
  void add_keyframe(const geometry::SE3& T_odom_body, std::vector<PointNormal> features_body);

  /// Changes the poses of the newest keyframes. @param poses oldest first; poses beyond the stored
  /// keyframes are ignored
  void move_newest(std::span<const geometry::SE3> poses);

  /// Makes the keyframes nearest to p_odom the submap; cheap if it does not change.
  void select_near(const geometry::Vec3& p_odom);

  /// The plane at a point observed with unit normal n_odom; false with fewer than 3 neighbours.
  [[nodiscard]] bool plane_at(const geometry::Vec3& p_odom, const geometry::Vec3& n_odom,
                              LocalPlane& out) const;

  void clear();

  [[nodiscard]] std::size_t keyframes() const { return keyframes_.size(); }

  [[nodiscard]] std::uint64_t forgotten() const { return forgotten_; }

  [[nodiscard]] std::size_t points() const { return grid_.size(); }

 private:
  struct StoredKeyframe {
    std::uint64_t number = 0;
    geometry::SE3 T_odom_body;
    std::vector<PointNormal> features_body;
  };

  void rebuild();

  double radius_m_;
  float cos_normal_max_;
  std::size_t selected_max_;
  std::size_t kept_max_;
  std::deque<StoredKeyframe> keyframes_;
  std::uint64_t next_number_ = 0;
  std::uint64_t forgotten_ = 0;

  std::vector<std::uint64_t> selected_;  ///< keyframe numbers, ascending
  std::vector<std::uint64_t> wanted_;
  std::vector<std::pair<double, std::uint64_t>> distances_;
  std::vector<PointNormal> gathered_;
  geometry::Vec3 origin_odom_ = geometry::Vec3::Zero();  ///< of the grid: keeps floats small
  PointGrid grid_;
};

}  // namespace rali::odometry::paper
