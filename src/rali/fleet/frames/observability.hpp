#pragma once

#include <string>

#include "rali/fleet/frames/hypotheses.hpp"

namespace rali::fleet {

/// What is missing, or what to do about it (algorithms_fleet 7.3).
enum class Advice {
  kEnough,          ///< nothing is missing
  kNoContact,       ///< neither ranges nor scans tie the two
  kWaiting,         ///< too few ranges
  kHeadingUnknown,  ///< one of them stands
  kMirror,          ///< left or right of a straight way
  kParallel,        ///< both straight, side by side
  kAlike,           ///< paths alike: two headings fit
  kDistance,        ///< the distance does not change
  kOffset,          ///< offset of the radios and place are one
  kSeveral,         ///< several places fit, for no reason of the above
  kLookAlike,       ///< the same, and only scans tell
  kContradict,      ///< places recognised without rival deny each other, and only scans tell
  kSlides,          ///< scans fit all along a way, and only they tell
  kNotYet,          ///< one place fits, but too loosely
  kHeight,          ///< height between the two is not known
  kMisfit,          ///< no place fits: ranges contradict odometry
  kTooGood,         ///< residuals far smaller than their sigmas: the sigmas are wrong
  kNotVerified,     ///< scans do not overlap where they should
  kNoPrior,         ///< preset paper needs a start pose
  kSmallMap,        ///< preset paper waits for keyframes
  kDrift,           ///< enough, were it not for the drift of odometry
  kFewViews         ///< only scans tell, and too few of them beyond doubt
};

/// What is known of a transform. The eigenvalues, in units of CommitSettings (1 deg, 0.1 m), say
/// what the geometry tells if odometry is exact; the sigmas contain its drift.
struct Observability {
  int ranges = 0;
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();   ///< of (yaw, x, y), ascending
  Eigen::Matrix3d eigenvectors = Eigen::Matrix3d::Zero();  ///< columns; scaled units
  double yaw_sigma_rad = 0.0, place_sigma_m = 0.0, z_sigma_m = 0.0;
  bool heading_known = false;
  bool sufficient = false;
  int rivals = 0;                         ///< besides the best that are not yet refuted
  double rival_m = 0.0, rival_rad = 0.0;  ///< how far the first of them is from the best
  Advice advice = Advice::kNoContact;
  bool a_stands = false, b_stands = false;
};

/// Judges the best hypothesis and its rivals.
[[nodiscard]] Observability observability(const HypothesisSet& set, const InitSettings& settings);

/// The eigenvalues of (yaw, x, y) of an information on (yaw, place), scaled; z integrated out.
[[nodiscard]] Eigen::Matrix3d scaled_planar_information(const Mat4& information,
                                                        const CommitSettings& settings);

/// One sentence or two for the user: what is missing between vehicles a and b and what to do.
[[nodiscard]] std::string advice_text(Advice advice, const Observability& seen,
                                      const std::string& a, const std::string& b,
                                      const InitSettings& settings);

}  // namespace rali::fleet
