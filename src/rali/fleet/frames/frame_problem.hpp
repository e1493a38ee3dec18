#pragma once

#include <cstddef>
#include <set>
#include <vector>

#include <Eigen/Core>

#include "rali/fleet/frames/pair_track.hpp"
#include "rali/fleet/frames/pose_evidence.hpp"
#include "rali/fleet/frames/settings.hpp"

namespace rali::fleet {

/// One range of a problem; a and b are indices of frames.
struct RangeTerm {
  std::size_t a = 0, b = 0, pair = 0;
  Time t;
  geometry::Vec3 x_m, y_m;
  double range_m = 0.0, sigma_m = 0.1;
  Eigen::Matrix3Xd x_drift, y_drift;  ///< position part of the DriftBasis of both ends
  /// The user's start poses relate both ends, so the solution is near its start: the loss of the
  /// range has a maximum. Many ranges around corners, metres too long, else pull off the start
  /// pose.
  bool bounded = false;
};

/// Alternatives of which at most one is true.
struct EvidenceGroup {
  std::vector<PoseEvidence> alternatives;
  std::vector<std::size_t> a, b;                   ///< indices of their frames
  std::vector<Eigen::Matrix4Xd> a_drift, b_drift;  ///< DriftBasis of both bodies
  /// Information if the errors of both paths are unknown: for a solution not adapted to it.
  std::vector<Mat4> apart;
};

/// Frames of some vehicles, the first of which is fixed. Unknowns are yaw and pivot position of all
/// others, the offset of each pair of radios and the errors of each path.
struct FrameProblem {
  std::vector<StreamKey> keys;
  std::vector<geometry::Vec3> pivots_m;  ///< per frame: start of its path
  std::vector<Eigen::Index> drifts;      ///< per frame: number of parameters of its path error
  std::size_t pairs = 0;
  std::vector<RangeTerm> ranges;
  std::vector<EvidenceGroup> evidence;
  InitSettings settings;

  [[nodiscard]] Eigen::Index frame_size() const {
    return 4 * (static_cast<Eigen::Index>(keys.size()) - 1);
  }

  [[nodiscard]] Eigen::Index bias_size() const {
    return settings.bias_sigma_m > 0.0 ? static_cast<Eigen::Index>(pairs) : 0;
  }

  /// Index in FrameValues::others of the first parameter of a frame's path.
  [[nodiscard]] Eigen::Index drift_at(std::size_t frame) const;

  /// Of all unknowns: frames, offsets, errors of paths.
  [[nodiscard]] Eigen::Index size() const;
};

/// Tracks and evidence of which both ends are among `keys`. The prior on height differences and the
/// other priors are in the settings.
[[nodiscard]] FrameProblem make_frame_problem(const std::vector<StreamKey>& keys,
                                              const std::vector<PairTrack>& tracks,
                                              const std::vector<PoseEvidence>& evidence,
                                              const InitSettings& settings);

/// T_first_frame of each frame, as yaw and pivot position, and the remaining unknowns.
struct FrameValues {
  std::vector<YawPose> T_ref_odom;
  Eigen::VectorXd others;  ///< offsets [m], then errors of paths (unit variance); empty: zero
};

/// Accepted alternative of a group.
inline constexpr int kNoneHolds = -1;
inline constexpr int kNotAsked = -2;  ///< the group is left out and costs nothing

struct FrameSolution {
  FrameValues values;
  /// Of (yaw, pivot position) of all frames but the first; all other unknowns are marginalised.
  /// Zero where unobservable.
  Eigen::MatrixXd information;
  Eigen::MatrixXd offset_information;  ///< the same if odometry and offsets of radios were exact
  Eigen::MatrixXd drift_information;   ///< the same if odometry alone were exact
  Eigen::MatrixXd prior_information;   ///< the part of it from the user's prior
  std::vector<int> holds;              ///< per group of evidence
  double chi2 = 0.0;                   ///< of all terms, for comparison with rivals
  double prior_chi2 = 0.0;             ///< the part of it from the user's prior
  double obstructed_chi2 = 0.0;        ///< the part that obstructed lines of sight would explain
  double fit_chi2 = 0.0;               ///< of the accepted terms
  int dof = 0;                         ///< of fit_chi2
  bool valid = false;                  ///< false: the solution is not finite
};

/// Least squares (damped Gauss-Newton, robust loss on ranges) from `start`, with the given
/// alternatives.
[[nodiscard]] FrameSolution solve_frames(const FrameProblem& problem, const FrameValues& start,
                                         const std::vector<int>& holds);

/// Per group the alternative with the least cost at these values, or none. The values are not
/// adapted to any.
[[nodiscard]] std::vector<int> best_alternatives(const FrameProblem& problem,
                                                 const FrameValues& values, bool none_allowed);

/// Initial choice of alternatives. None is chosen where even the nearest is neither plausible at
/// these values nor within the distance of one hypothesis. If it were accepted, a wrong
/// registration of 1 cm sigma would pull the frames away before any choice is made.
[[nodiscard]] std::vector<int> near_alternatives(const FrameProblem& problem,
                                                 const FrameValues& values);

/// solve_frames() with the alternatives re-selected until they no longer change.
/// @param kept groups of evidence whose alternatives stay as in `start`
[[nodiscard]] FrameSolution solve_frames_choosing(const FrameProblem& problem,
                                                  const FrameSolution& start,
                                                  const std::set<std::size_t>& kept = {});

}  // namespace rali::fleet
