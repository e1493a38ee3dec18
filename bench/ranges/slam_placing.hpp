#pragma once

#include <map>

#include "rali/ranging/anchor_finder.hpp"
#include "slam_problem.hpp"

namespace rali::ranges_bench {

/// A beacon's place in odom before any graph, without truth.
struct PlacedBeacon {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  std::size_t after_range = 0;  ///< index of the range with which it was found
  bool certain = false;         ///< the finder would have told the vehicle; else its best guess
};

/// Finds one beacon along a track as the vehicle does (ranging::AnchorFinder).
class BeaconFinder {
 public:
  explicit BeaconFinder(const SlamProblem& problem);

  /// @param variance_m2 of the position, per axis
  std::optional<ranging::FoundAnchor> add(const TrackRange& range, const geometry::Vec3& p_odom_m,
                                          double variance_m2);

 private:
  ranging::AnchorFinder finder_;
};

/// Beacons from ranges along the odometry. What the finder does not dare to tell is the best of
/// its minima over the first ranges.
[[nodiscard]] std::map<int, PlacedBeacon> place_beacons(const SlamProblem& problem,
                                                        const eval::PoseList& odometry);

/// Ranges from which the frame is found before the odometry has drifted far.
inline constexpr std::size_t kFewRanges = 40;

/// Where odom lies in world (x, y, yaw about the level track), from the first `most` ranges to
/// known points: least squares begun at many headings and places on the circle of the first range.
[[nodiscard]] geometry::SE3 place_frame(const SlamProblem& problem, const eval::PoseList& odometry,
                                        std::size_t most);

/// Variance of the position per axis that the steps before pose k add up to.
[[nodiscard]] std::vector<double> position_variances(const SlamProblem& problem);

}  // namespace rali::ranges_bench
