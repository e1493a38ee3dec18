#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pyfg.hpp"
#include "rali/eval/association.hpp"
#include "rali/graph/pose_graph.hpp"

namespace rali::ranges_bench {

/// A range from a pose of the track to a beacon whose place is not known, or to a known point.
struct TrackRange {
  Time t;
  std::size_t pose = 0;  ///< index in the track
  std::optional<int> beacon;
  geometry::Vec3 p_known_m = geometry::Vec3::Zero();  ///< in world, if no beacon
  double range_m = 0.0;
  double sigma_m = 0.1;
};

/// One robot's odometry and its ranges. What is true serves the evaluation only, but for the known
/// points.
struct SlamProblem {
  std::string name;
  bool planar = false;
  eval::PoseList truth;                          ///< in world, one per pose of the track
  std::vector<graph::RelativePoseFactor> steps;  ///< step k from pose k to k + 1
  std::vector<TrackRange> ranges;                ///< in the order of their poses
  std::map<int, geometry::Vec3> beacons_m;       ///< true places
  double bias_sigma_m = 0.0;                     ///< of a constant error per beacon; 0: none

  /// True if the ranges go to points that are known in world: then the first pose is not.
  [[nodiscard]] bool known_points() const { return beacons_m.empty(); }
};

/// Which ranges of a file count.
enum class Ends {
  kBeacons,      ///< to landmarks, whose places are not known
  kStanding,     ///< to robots that stand, whose places are not known
  kKnownRobots,  ///< to other robots, where they truly were
};

/// The part of a file that is one robot's. Errors (kNoAnswer): no range of that kind; (kInput):
/// odometry with a gap.
[[nodiscard]] Result<SlamProblem> problem_of(const Pyfg& file, const std::string& name, char robot,
                                             Ends ends);

/// The same with the ranges of a raw Plaza file (t, sender, receiver, metres), not calibrated:
/// each beacon gets a constant error with a wide prior.
[[nodiscard]] Result<SlamProblem> with_raw_ranges(SlamProblem plaza,
                                                  const std::filesystem::path& path);

/// The same, told sigmas as large as the errors of its steps and ranges against the truth.
[[nodiscard]] SlamProblem with_measured_sigmas(SlamProblem problem);

/// Squared errors of the steps by the covariance told, per degree of freedom: 1 would be honest.
[[nodiscard]] double steps_nees(const SlamProblem& problem);

/// Of the ranges against the truth.
[[nodiscard]] double range_rms_m(const SlamProblem& problem);

/// Steps laid one behind the other, from the identity.
[[nodiscard]] eval::PoseList odometry_alone(const SlamProblem& problem);

/// Robots of a file, but for landmarks.
[[nodiscard]] std::vector<char> robots_of(const Pyfg& file);

}  // namespace rali::ranges_bench
