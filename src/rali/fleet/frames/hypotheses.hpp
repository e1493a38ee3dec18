#pragma once

#include <cstddef>
#include <vector>

#include "rali/fleet/frames/frame_problem.hpp"
#include "rali/fleet/frames/range_starts.hpp"

namespace rali::fleet {

/// Vehicles whose odom frames are tied together; the first is the reference.
struct FrameGroup {
  std::vector<StreamKey> keys;
  std::vector<YawPose> T_ref_odom;  ///< per key; of the first the identity
};

/// One way in which the frames of two groups may lie to each other.
struct FrameHypothesis {
  YawPose T_b_a;  ///< of the references
  /// Where the path of a's reference begins, in its odom frame: the information is of (yaw, place
  /// of this point in b), all else integrated out. Zero eigenvalues: not known at all.
  geometry::Vec3 pivot_a_m = geometry::Vec3::Zero();
  Mat4 information = Mat4::Zero();
  Mat4 drift_information = Mat4::Zero();   ///< the same if odometry were exact: the geometry's
  Mat4 offset_information = Mat4::Zero();  ///< and if offsets of the radios were known besides
  Mat4 prior_information = Mat4::Zero();   ///< the part of it that the user gave
  double chi2 = 0.0;                       ///< for comparison with rivals
  double prior_chi2 = 0.0;                 ///< the user's part of it
  /// Unrivalled scans that hold, of pieces of both paths that are CommitSettings::view_apart_m
  /// apart.
  int views = 0;
  bool scans = false;      ///< a comparison of scans holds
  FrameSolution solution;  ///< of all vehicles of both groups, those of b first

  [[nodiscard]] geometry::Vec3 place_b_m() const { return T_b_a * pivot_a_m; }
};

/// All that is left, cheapest first.
struct HypothesisSet {
  std::vector<FrameHypothesis> all;
  std::vector<PlanarRange> ranges;  ///< between the groups, x in a's and y in b's reference frame
  bool a_stands = false, b_stands = false;
  bool has_prior = false;
  bool only_scans = false;  ///< nothing but what scans show: no prior, and no range

  /// Inflation of chi2 by a fit that is worse than its sigmas (7.4, step 4).
  [[nodiscard]] double inflation() const;

  /// (chi2 of k - chi2 of the best) / inflation.
  [[nodiscard]] double gap(std::size_t k) const;
};

/// Whether two hypotheses are one: nearer than `merge_m` and `merge_deg`.
[[nodiscard]] bool same_place(const FrameHypothesis& h, const FrameHypothesis& k,
                              const SearchSettings& settings);

/// Every way in which group a may lie in group b, by ranges, scans and priors together
/// (algorithms_fleet 7.4, steps 1 to 4): starts from a search of the plane by ranges and from each
/// piece of evidence, each refined with errors of odometry, offsets of radios and the alternatives
/// chosen anew; merged; at most `hypotheses_max` kept. With CommitRule::kAtSize only what the prior
/// leads to.
[[nodiscard]] HypothesisSet group_hypotheses(const FrameGroup& a, const FrameGroup& b,
                                             const std::vector<PairTrack>& tracks,
                                             const std::vector<PoseEvidence>& evidence,
                                             const InitSettings& settings);

/// The same for two vehicles: T_b_a of the track's ends.
[[nodiscard]] HypothesisSet joint_hypotheses(const PairTrack& track,
                                             const std::vector<PoseEvidence>& evidence,
                                             const InitSettings& settings);

[[nodiscard]] HypothesisSet range_hypotheses(const PairTrack& track, const InitSettings& settings);

/// Information on (yaw, place of a's first antenna) that a track has where T_b_a is true.
[[nodiscard]] Mat4 pair_information(const PairTrack& track, const YawPose& T_b_a,
                                    const InitSettings& settings);

}  // namespace rali::fleet
