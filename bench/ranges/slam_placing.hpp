#pragma once

#include <map>

#include "rali/ranging/anchor_finder.hpp"
#include "slam_problem.hpp"

namespace rali::ranges_bench {

/// A beacon's initial position in odom, before any graph and without ground truth.
struct PlacedBeacon {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  std::size_t after_range = 0;  ///< index of the range with which it was initialised
  bool certain = false;         ///< accepted by the finder; else its best guess
};

/// Initialises one beacon along a track as the vehicle does (ranging::AnchorFinder).
class BeaconFinder {
 public:
  explicit BeaconFinder(const SlamProblem& problem);

  /// @param variance_m2 of the position, per axis
  std::optional<ranging::FoundAnchor> add(const TrackRange& range, const geometry::Vec3& p_odom_m,
                                          double variance_m2);

 private:
  ranging::AnchorFinder finder_;
};

/// Initialises beacons from ranges along the odometry. Where the finder accepts no solution, the
/// best of its minima over the first ranges is used.
[[nodiscard]] std::map<int, PlacedBeacon> place_beacons(const SlamProblem& problem,
                                                        const eval::PoseList& odometry);

/// Number of ranges for initialising the frame before the odometry has drifted far.
inline constexpr std::size_t kFewRanges = 40;

/// Pose of odom in world (x, y, yaw for a level track) from the first `maximum` ranges to known
/// points: least squares from many initial headings and positions on the circle of the first range.
[[nodiscard]] geometry::SE3 place_frame(const SlamProblem& problem, const eval::PoseList& odometry,
                                        std::size_t maximum);

/// Position variance per axis accumulated by the steps before pose k.
[[nodiscard]] std::vector<double> position_variances(const SlamProblem& problem);

}  // namespace rali::ranges_bench
