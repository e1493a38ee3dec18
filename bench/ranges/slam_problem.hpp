#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pyfg.hpp"
#include "rali/eval/association.hpp"
#include "rali/graph/pose_graph.hpp"

namespace rali::ranges_bench {

/// A range from a pose of the track to a beacon of unknown position, or to a known point.
struct TrackRange {
  Time t;
  std::size_t pose = 0;  ///< index in the track
  std::optional<int> beacon;
  geometry::Vec3 p_known_m = geometry::Vec3::Zero();  ///< in world, if no beacon
  double range_m = 0.0;
  double sigma_m = 0.1;
};

/// One robot's odometry and its ranges. Ground truth is used for the evaluation only, except for
/// the known points.
struct SlamProblem {
  std::string name;
  bool planar = false;
  eval::PoseList truth;                          ///< in world, one per pose of the track
  std::vector<graph::RelativePoseFactor> steps;  ///< step k from pose k to k + 1
  std::vector<TrackRange> ranges;                ///< in the order of their poses
  std::map<int, geometry::Vec3> beacons_m;       ///< true positions
  double bias_sigma_m = 0.0;                     ///< sigma of a constant error per beacon; 0: none

  /// True if the ranges are to known points in world: then the first pose is unknown.
  [[nodiscard]] bool known_points() const { return beacons_m.empty(); }
};

/// Which ranges of a file are used.
enum class Ends {
  kBeacons,      ///< to landmarks with unknown positions
  kStanding,     ///< to stationary robots with unknown positions
  kKnownRobots,  ///< to other robots at their true positions
};

/// The problem of one robot in a file. Errors (kNoAnswer): no range of that kind; (kInput):
/// odometry with a gap.
[[nodiscard]] Result<SlamProblem> problem_of(const Pyfg& file, const std::string& name, char robot,
                                             Ends ends);

/// The same with the ranges of a raw Plaza file (t, sender, receiver, metres), not calibrated: each
/// beacon gets a constant error with a wide prior.
[[nodiscard]] Result<SlamProblem> with_raw_ranges(SlamProblem plaza,
                                                  const std::filesystem::path& path);

/// The same with sigmas that equal the errors of its steps and ranges against ground truth.
[[nodiscard]] SlamProblem with_measured_sigmas(SlamProblem problem);

/// Squared errors of the steps by their stated covariance, per degree of freedom: 1 if consistent.
[[nodiscard]] double steps_nees(const SlamProblem& problem);

/// RMS error of the ranges against ground truth.
[[nodiscard]] double range_rms_m(const SlamProblem& problem);

/// Chained steps, from the identity.
[[nodiscard]] eval::PoseList odometry_alone(const SlamProblem& problem);

/// Robots of a file, without landmarks.
[[nodiscard]] std::vector<char> robots_of(const Pyfg& file);

}  // namespace rali::ranges_bench
