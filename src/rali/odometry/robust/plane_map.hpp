#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/geometry/se3.hpp"
#include "rali/odometry/robust/plane_fit.hpp"
#include "rali/odometry/robust/view_planes.hpp"

namespace rali::odometry {

struct PlaneMapSettings {
  double voxel_m = 0.8;          ///< edge of a root cell; split twice if it holds no plane
  int freeze_points = 400;       ///< a plane with this many points takes no more
  double refit_growth = 1.25;    ///< refit when the number of points has grown by this factor
  int roots_max = 400000;        ///< beyond: cells far from the vehicle are removed
  double keep_radius_m = 150.0;  ///< cells within are never removed
  PlaneSettings plane;

  template <class V>
  void visit(V& v) {
    v("voxel_m", voxel_m, 0.1, 10.0,
      "edge of the largest map cells [m], split twice where they hold no plane");
    v("freeze_points", freeze_points, 20, 100000, "a plane of so many points takes no more");
    v("refit_growth", refit_growth, 1.01, 4.0, "fit again when points have grown by this factor");
    v("roots_max", roots_max, 1000, 20000000, "more cells: those far away are forgotten");
    v("keep_radius_m", keep_radius_m, 1.0, 10000.0, "cells nearer than this are never forgotten");
    v.group("plane", plane, "what counts as a plane");
  }
};

/// The map of the filter: planes with covariance in a sparse octree of three levels
/// (0.8, 0.4, 0.2 m) over an open-addressing hash of root cells, all in odom.
///
/// A cell accumulates sums of points. If they form a plane it holds one, refitted as points come
/// and frozen when it has enough; if not, its eight children accumulate instead. Wide planes with a
/// measured thickness keep the information consistent (algorithms 2.2, 2.3).
class PlaneMap {
 public:
  explicit PlaneMap(const PlaneMapSettings& settings);

  /// Sets the sensor pose of later insertions. Until the sensor has moved by 5 cm, or turned as
  /// far, a point is a sample of the surface only where no ray has passed before.
  void set_view(const geometry::SE3& T_odom_lidar);

  /// @param ray_odom unit vector from the sensor to the point.
  /// @param epoch generation of the observing pose (drift.hpp).
  void insert(const geometry::Vec3& p_odom_m, const geometry::Vec3f& ray_odom, double epoch);

  /// Planes of this scan are used where no cell holds a plane, until the next call.
  void set_scan(const ViewPlanes& scan);

  /// Whether the sensor has moved far enough for a new set_scan().
  [[nodiscard]] bool wants_scan(const geometry::SE3& T_odom_lidar) const {
    return !scan_ || scan_->is_left(T_odom_lidar);
  }

  /// Index of the plane in whose cell the point lies, else of the scan's plane in its direction; -1
  /// if none.
  [[nodiscard]] int find(const geometry::Vec3& p_odom_m) const;

  /// As find(), but also searches the root cells beyond the nearest faces and takes the plane with
  /// the smallest distance along its normal: for a guess that may be half a cell off.
  [[nodiscard]] int find_near(const geometry::Vec3& p_odom_m) const;

  [[nodiscard]] const Plane& plane(int index) const {
    return planes_[static_cast<std::size_t>(index)];
  }

  [[nodiscard]] std::size_t plane_count() const { return planes_.size(); }

  [[nodiscard]] std::size_t root_count() const { return roots_; }

  [[nodiscard]] bool empty() const { return roots_ == 0; }

  /// Removes root cells farther than the keep radius from `center` if there are too many. Repeated
  /// only after roots_max / 8 new ones: it copies the map, which would be too slow with every scan
  /// if the cells within the radius alone are too many.
  /// @return number of root cells removed.
  std::size_t prune(const geometry::Vec3& center_odom_m);

  [[nodiscard]] const PlaneMapSettings& settings() const { return settings_; }

  [[nodiscard]] std::uint64_t hash() const;

 private:
  static constexpr int kLevels = 3;

  /// The part of a cell that a search reads: small, so that eight children fit one cache line.
  struct Node {
    int plane = -1;          ///< index into planes_
    int children = kGather;  ///< index of the first of eight cells, or one of the two below
  };

  static constexpr int kGather = -1;  ///< no children: the cell takes points
  static constexpr int kFrozen = -2;  ///< no children: the cell takes no more points

  /// The part of a cell that insertion updates.
  struct Gathered {
    PointSums sums;
    int refit_at = 0;
  };

  struct Slot {
    std::uint64_t key = 0;
    int cell = -1;
  };

  [[nodiscard]] int in_scan(const geometry::Vec3& p_odom_m) const;
  int root_cell(int ix, int iy, int iz) const;
  int add_cells(std::size_t n);
  int find_or_make_root(int ix, int iy, int iz);
  void grow();
  void insert_at(int cell, const geometry::Vec3& origin, double half_m, int level,
                 const geometry::Vec3& p, const geometry::Vec3f& ray, double epoch);
  void refit(int cell, const geometry::Vec3& origin, int level);
  int descend(int cell, const geometry::Vec3& origin, const geometry::Vec3& p) const;
  void copy_tree(const PlaneMap& from, int source, int target);
  void consider(int ix, int iy, int iz, const geometry::Vec3& p, int& best, double& best_m) const;

  PlaneMapSettings settings_;
  double inverse_voxel_ = 1.0;  ///< [1/m]
  std::vector<Slot> slots_;
  std::vector<Node> nodes_;
  std::vector<Gathered> gathered_;  ///< parallel to nodes_
  std::vector<Plane> planes_;
  std::optional<ViewPlanes> scan_;
  std::vector<int>
      scan_planes_;  ///< index into planes_ of each of its planes; the next scan reuses the slots
  geometry::SE3 T_odom_view_;  ///< where the newest view started
  bool new_view_ = true;
  std::size_t roots_ = 0;
  std::size_t prune_above_ = 0;  ///< roots
};

}  // namespace rali::odometry
