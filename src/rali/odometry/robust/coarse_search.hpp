#pragma once

#include <deque>
#include <span>
#include <vector>

#include "rali/odometry/deskew.hpp"

namespace rali::odometry {

/// When and how far to search before an update without inertial data.
struct CoarseSearchSettings {
  double sigma_min_m = 0.15;  ///< with a better guess no search is needed
  double sigma_min_deg = 4.0;
  double range_max_m = 1.5;
  double range_max_deg = 60.0;
  int points = 300;
  /// Without inertial data: a scan that contradicts the last one is searched wherever the vehicle
  /// can have moved, which costs as much as ten other scans.
  bool wide = true;

  template <class V>
  void visit(V& v) {
    v("sigma_min_m", sigma_min_m, 0.0, 10.0, "search where the guess is worse than this");
    v("sigma_min_deg", sigma_min_deg, 0.0, 180.0, "or turned by more than this");
    v("range_max_m", range_max_m, 0.0, 20.0, "how far to search at most");
    v("range_max_deg", range_max_deg, 0.0, 180.0, "how far to turn at most");
    v("points", points, 50, 10000, "points compared per trial");
    v("wide", wide, "LiDAR alone: search scans that contradict the last one");
  }
};

/// The points of the last scans in odom, which the next one must overlap. Unlike planes, which need
/// many points per cell, they cover a new area from its first scan on.
class RecentPoints {
 public:
  void add(const BodyPoints& points, const geometry::SE3& T_odom_body);

  void clear() {
    scans_.clear();
    poses_.clear();
  }

  /// In odom, oldest first.
  [[nodiscard]] const std::deque<std::vector<geometry::Vec3f>>& scans() const { return scans_; }

  /// T_odom_body of each.
  [[nodiscard]] const std::deque<geometry::SE3>& poses() const { return poses_; }

 private:
  std::deque<std::vector<geometry::Vec3f>> scans_;
  std::deque<geometry::SE3> poses_;
};

/// A guess and its horizontal and heading uncertainty (1 sigma).
struct PoseGuess {
  geometry::SE3 T_odom_body;
  double sigma_m = 0.0;
  double sigma_rad = 0.0;
};

/// The guess given by a prediction of covariance P (boxplus order). Uncertainty along the `unseen`
/// translations (unit, odom), and what correlates with it, is left out. No scan can decide it, and
/// the number of trials would grow with every metre along a tunnel.
[[nodiscard]] PoseGuess guess_from(const geometry::SE3& T_odom_body, const geometry::Mat6& P,
                                   std::span<const geometry::Vec3> unseen,
                                   const geometry::Vec3& up_odom);

/// Whether the guess is so poor that the nearest minimum of the registration may be a wrong one.
[[nodiscard]] bool needs_search(const PoseGuess& guess, const CoarseSearchSettings& settings);

/// Tries poses on a grid around the guess (heading and horizontal position) and refines the best
/// ones by hill climbing in all six directions. Returns those at which most points lie near points
/// of the last scans, best first; distant trials are penalised by their distance in sigma. Empty if
/// there is too little to compare. For scans so far apart (2 Hz) that the nearest minimum of the
/// registration is a wrong one. The grid scales with the scene: its cells are a fixed fraction of
/// the median range.
[[nodiscard]] std::vector<geometry::SE3> search_pose(const RecentPoints& recent,
                                                     const BodyPoints& points,
                                                     const PoseGuess& guess,
                                                     const geometry::Vec3& up_odom,
                                                     const CoarseSearchSettings& settings);

}  // namespace rali::odometry
