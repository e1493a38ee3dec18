#pragma once

#include <optional>
#include <vector>

#include "rali/fleet/frames/path_sample.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/fleet/frames/yaw_pose.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet {

enum class EvidenceSource {
  kPrior,  ///< given by the user
  kScan,   ///< a verified registration
  kRidge   ///< degenerate along a passage: no information along it
};

/// A compared body on its path.
struct ComparedBody {
  PathSample start;  ///< of its path
  PathSample body;
};

/// A measurement other than ranges of the transform between two odom frames. Alternatives of which
/// at most one is true carry the same `group` (the two results of a half-turn symmetry, the doors
/// of a corridor). The information may be singular.
struct PoseEvidence {
  StreamKey a, b;
  double yaw_rad = 0.0;  ///< of T_b_a
  /// A point of a's frame near the observation, and its position in b: so a heading error does not
  /// shift a far origin.
  geometry::Vec3 pivot_a_m = geometry::Vec3::Zero();
  geometry::Vec3 place_b_m = geometry::Vec3::Zero();
  Mat4 information = Mat4::Zero();  ///< of (yaw, position), position in b [rad, m]
  /// With both, errors of the paths until then are not in the information: they are those that the
  /// ranges at that time have as well.
  std::optional<ComparedBody> on_a, on_b;
  EvidenceSource source = EvidenceSource::kScan;
  int group = -1;            ///< alternatives share it; negative: no group
  double chi2 = 0.0;         ///< its own, to compare alternatives
  double wrong_chi2 = 16.0;  ///< cost of rejecting all of the group
  bool unrivalled = false;   ///< a scan match without a rival place
  /// A scan match searched where a hypothesis predicts it, with those of the other hypotheses as
  /// alternatives.
  bool tested = false;
  double point_sigma_m = 0.0;  ///< sigma per point assumed by the information; 0: unknown

  /// T_b_a of this evidence.
  [[nodiscard]] YawPose T_b_a() const;
};

/// A start pose given by the user, with the sigmas of the settings.
[[nodiscard]] PoseEvidence prior_evidence(StreamKey a, StreamKey b, const YawPose& T_b_a,
                                          const InitSettings& settings);

/// A registration of two keyframes as evidence between the odom frames: T_kb_ka maps keyframe ka of
/// vehicle a to keyframe kb of b; its information is of graph::RelativePoseFactor (rotation in ka,
/// translation in kb). Roll and pitch are marginalised with the settings' sigma of tilt.
[[nodiscard]] PoseEvidence keyframe_evidence(
    StreamKey a, StreamKey b, const geometry::SE3& T_odoma_ka, const geometry::SE3& T_odomb_kb,
    const geometry::SE3& T_kb_ka, const geometry::Mat6& information, const InitSettings& settings);

}  // namespace rali::fleet
