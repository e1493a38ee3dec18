#pragma once

#include <cstddef>
#include <vector>

#include "rali/fleet/frames/frame_problem.hpp"
#include "rali/fleet/frames/range_starts.hpp"

namespace rali::fleet {

/// Vehicles whose odom frames are connected; the first is the reference.
struct FrameGroup {
  std::vector<StreamKey> keys;
  std::vector<YawPose> T_ref_odom;  ///< per key; of the first the identity
};

/// One candidate transform between the frames of two groups.
struct FrameHypothesis {
  YawPose T_b_a;  ///< of the references
  /// Start of the path of a's reference, in its odom frame. The information is of (yaw, position of
  /// this point in b), all else marginalised. Zero eigenvalues: unobservable.
  geometry::Vec3 pivot_a_m = geometry::Vec3::Zero();
  Mat4 information = Mat4::Zero();
  Mat4 drift_information = Mat4::Zero();   ///< the same with exact odometry: geometry only
  Mat4 offset_information = Mat4::Zero();  ///< and with known radio offsets as well
  Mat4 prior_information = Mat4::Zero();   ///< the part of it from the user's prior
  double chi2 = 0.0;                       ///< for comparison with rivals
  double prior_chi2 = 0.0;                 ///< the part of it from the user's prior
  int priors_denied = 0;                   ///< start poses between the groups that it rejects
  /// Unambiguous scan matches that agree, of parts of both paths that are
  /// CommitSettings::view_apart_m apart.
  int views = 0;
  bool scans = false;      ///< a comparison of scans agrees
  FrameSolution solution;  ///< of all vehicles of both groups, those of b first

  [[nodiscard]] geometry::Vec3 place_b_m() const { return T_b_a * pivot_a_m; }
};

/// All remaining hypotheses, cheapest first.
struct HypothesisSet {
  std::vector<FrameHypothesis> all;
  std::vector<PlanarRange> ranges;  ///< between the groups, x in a's and y in b's reference frame
  bool a_stands = false, b_stands = false;
  bool has_prior = false;
  bool only_scans = false;  ///< only evidence from scans: no prior, and no range

  /// Inflation of chi2 where the residuals exceed their sigmas (7.4, step 4).
  [[nodiscard]] double inflation() const;

  /// (chi2 of k - chi2 of the best) / inflation.
  [[nodiscard]] double gap(std::size_t k) const;

  /// The same without what k must pay for ranges that are longer than the line of sight. They share
  /// their obstacles: by their number they would outweigh all else.
  [[nodiscard]] double gap_unobstructed(std::size_t k) const;
};

/// Whether two hypotheses are equal: closer than `merge_m` and `merge_deg`.
[[nodiscard]] bool same_place(const FrameHypothesis& h, const FrameHypothesis& k,
                              const SearchSettings& settings);

/// All candidate transforms between group a and group b, by ranges, scans and priors together
/// (algorithms_fleet 7.4, steps 1 to 4). Starts come from a planar search by ranges and from each
/// piece of evidence. Each is refined with errors of odometry, offsets of radios and re-selected
/// alternatives, then they are merged; at most `hypotheses_max` are kept. With CommitRule::kAtSize
/// only the result of the prior is kept.
[[nodiscard]] HypothesisSet group_hypotheses(const FrameGroup& a, const FrameGroup& b,
                                             const std::vector<PairTrack>& tracks,
                                             const std::vector<PoseEvidence>& evidence,
                                             const InitSettings& settings);

/// The same for two vehicles: T_b_a of the track's ends.
[[nodiscard]] HypothesisSet joint_hypotheses(const PairTrack& track,
                                             const std::vector<PoseEvidence>& evidence,
                                             const InitSettings& settings);

[[nodiscard]] HypothesisSet range_hypotheses(const PairTrack& track, const InitSettings& settings);

/// Information of a track on (yaw, position of a's first antenna) if T_b_a is true.
[[nodiscard]] Mat4 pair_information(const PairTrack& track, const YawPose& T_b_a,
                                    const InitSettings& settings);

}  // namespace rali::fleet
