#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "rali/fleet/frames/pair_track.hpp"
#include "rali/fleet/frames/pose_evidence.hpp"
#include "rali/fleet/frames/settings.hpp"

namespace rali::fleet {

/// One range of a problem; a and b are indices of frames.
struct RangeTerm {
  std::size_t a = 0, b = 0, pair = 0;
  geometry::Vec3 x_m, y_m;
  double range_m = 0.0, sigma_m = 0.1;
  Eigen::Matrix3Xd x_drift, y_drift;  ///< drift_basis() of both ends
};

/// Alternatives of which at most one holds.
struct EvidenceGroup {
  std::vector<PoseEvidence> alternatives;
  std::vector<std::size_t> a, b;  ///< indices of their frames
};

/// Frames of some vehicles, the first of which is held: unknown are yaw and the place of a pivot of
/// all others, the offset of each pair of radios and the errors of each path.
struct FrameProblem {
  std::vector<StreamKey> keys;
  std::vector<geometry::Vec3> pivots_m;  ///< per frame: where its path begins
  std::vector<Eigen::Index> drifts;      ///< per frame: how many numbers describe its errors
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

  /// Of all unknowns: frames, offsets, errors of paths.
  [[nodiscard]] Eigen::Index size() const;
};

/// Tracks and evidence of which both ends are among `keys`. Priors of unequal heights and the rest
/// are in the settings.
[[nodiscard]] FrameProblem make_frame_problem(const std::vector<StreamKey>& keys,
                                              const std::vector<PairTrack>& tracks,
                                              const std::vector<PoseEvidence>& evidence,
                                              const InitSettings& settings);

/// T_first_frame of each frame, as yaw and place of the pivot, and the rest of the unknowns.
struct FrameValues {
  std::vector<YawPose> T_ref_odom;
  Eigen::VectorXd others;  ///< offsets [m], then errors of paths (unit variance)
};

/// Which alternative of a group holds.
inline constexpr int kNoneHolds = -1;
inline constexpr int kNotAsked = -2;  ///< the group is left out and costs nothing

struct FrameSolution {
  FrameValues values;
  /// Of (yaw, place of the pivot) of all frames but the first; all else is integrated out, what no
  /// observation tells is zero.
  Eigen::MatrixXd information;
  Eigen::MatrixXd offset_information;  ///< the same if odometry and offsets of radios were exact
  Eigen::MatrixXd drift_information;   ///< the same if odometry alone were exact
  Eigen::MatrixXd prior_information;   ///< the part of it that is the user's
  std::vector<int> holds;              ///< per group of evidence
  double chi2 = 0.0;                   ///< of all, for comparison with rivals
  double prior_chi2 = 0.0;             ///< the user's part of it
  double fit_chi2 = 0.0;               ///< of what is held for true
  int dof = 0;                         ///< of fit_chi2
  bool valid = false;                  ///< false: not a finite answer
};

/// Least squares (damped Gauss-Newton, Huber loss on ranges) from `start`, with the given
/// alternatives.
[[nodiscard]] FrameSolution solve_frames(const FrameProblem& problem, const FrameValues& start,
                                         const std::vector<int>& holds);

/// Per group the alternative that costs least at these values, or none.
[[nodiscard]] std::vector<int> best_alternatives(const FrameProblem& problem,
                                                 const FrameValues& values, bool none_allowed);

/// The same to begin with: none where even the nearest is neither believable at these values nor so
/// near that it would be one hypothesis with them. Held all the same, a wrong registration of 1 cm
/// would carry the frames off before any choice is made.
[[nodiscard]] std::vector<int> near_alternatives(const FrameProblem& problem,
                                                 const FrameValues& values);

/// solve_frames() with the alternatives chosen anew until they stay.
[[nodiscard]] FrameSolution solve_frames_choosing(const FrameProblem& problem,
                                                  const FrameSolution& start);

}  // namespace rali::fleet
