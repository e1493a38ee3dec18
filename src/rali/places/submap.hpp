#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/places/free_space.hpp"
#include "rali/places/grid_index.hpp"
#include "rali/places/planes.hpp"
#include "rali/places/scan.hpp"

namespace rali::places {

struct SubmapSettings {
  double range_max_m = 60.0;  ///< points farther from their LiDAR are left out
  int points_max = 200000;    ///< more are thinned evenly
  double check_m = 0.4;       ///< spacing of the points that are checked for contradictions
  PlaneSettings plane;
  FreeSpaceSettings free_space;

  template <class V>
  void visit(V& v) {
    v("range_max_m", range_max_m, 5.0, 500.0, "points farther from their LiDAR are left out");
    v("points_max", points_max, 1000, 10000000, "more points are thinned evenly");
    v("check_m", check_m, 0.1, 2.0, "spacing of points asked for contradictions");
    v.group("plane", plane, "what counts as a plane");
    v.group("free_space", free_space, "free space from rays");
  }
};

/// A point that is checked against the other submap.
struct CheckPoint {
  geometry::Vec3f p_m;
  geometry::Vec3f n = geometry::Vec3f::Zero();  ///< of its plane, towards the sensor; or 0
  bool upright = true;                          ///< not on a floor or ceiling
  bool solid = true;                            ///< no scans of its own submap passed through it
};

/// The scans of some metres of path as one rigid piece, in a frame `ref`: origin in the body of the
/// middle scan, z up (against gravity), x where that body's x points, seen from above. So two
/// submaps differ only by yaw and translation, up to the error of gravity. Immutable.
class Submap {
 public:
  [[nodiscard]] KeyframeId middle() const { return middle_; }

  [[nodiscard]] const std::vector<KeyframeId>& scans() const { return scans_; }

  /// Pose of the middle scan's body: a rotation, because the origins coincide.
  [[nodiscard]] const geometry::SE3& T_ref_body() const { return T_ref_body_; }

  [[nodiscard]] std::size_t points() const { return points_.size(); }

  /// Rounded to 2 mm where no point is farther than 65 m: a long mission keeps hundreds of submaps.
  [[nodiscard]] geometry::Vec3f point_m(std::size_t i) const {
    const Packed& p = points_[i];
    return step_m_ * geometry::Vec3f(p[0], p[1], p[2]);
  }

  [[nodiscard]] std::span<const Plane> planes() const { return planes_; }

  /// Searches planes by their mean point.
  [[nodiscard]] const GridIndex& plane_index() const { return plane_index_; }

  [[nodiscard]] std::span<const CheckPoint> checks() const { return checks_; }

  [[nodiscard]] const FreeSpace& free_space() const { return free_space_; }

  /// Height of the ground below the middle scan [m]; -1 if no level surface is below any sensor.
  [[nodiscard]] double ground_z_m() const { return ground_z_m_; }

  /// Sum of the distances between successive scans [m].
  [[nodiscard]] double path_m() const { return path_m_; }

  /// Places of the LiDAR, scan by scan.
  [[nodiscard]] std::span<const geometry::Vec3f> views_m() const { return views_; }

 private:
  friend Result<Submap> make_submap(std::span<const PosedScan>, std::size_t, const SubmapSettings&);

  using Packed = std::array<std::int16_t, 3>;

  void choose_checks(std::span<const geometry::Vec3f> points, double spacing_m);
  void find_ground();
  void keep(std::span<const geometry::Vec3f> points);

  KeyframeId middle_;
  std::vector<KeyframeId> scans_;
  geometry::SE3 T_ref_body_;
  std::vector<Packed> points_;
  float step_m_ = 0.0F;  ///< of the packed points
  std::vector<Plane> planes_;
  GridIndex plane_index_;
  std::vector<CheckPoint> checks_;
  FreeSpace free_space_;
  std::vector<geometry::Vec3f> views_;
  double ground_z_m_ = -1.0;
  double path_m_ = 0.0;
};

/// @param scans in the order of the path; @param middle the one whose body defines the frame.
/// Points that are not finite or too far are left out. Errors (kInput): no scan, a pose or an up
/// direction that is not finite, arrays of different length, no usable point.
[[nodiscard]] Result<Submap> make_submap(std::span<const PosedScan> scans, std::size_t middle,
                                         const SubmapSettings& settings);

}  // namespace rali::places
