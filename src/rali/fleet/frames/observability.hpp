#pragma once

#include <string>

#include "rali/fleet/frames/hypotheses.hpp"

namespace rali::fleet {

/// What is missing, or what the user can do about it (algorithms_fleet 7.3).
enum class Advice {
  kEnough,          ///< nothing is missing
  kNoContact,       ///< neither ranges nor scans connect the two
  kWaiting,         ///< too few ranges
  kHeadingUnknown,  ///< one of them is at standstill
  kMirror,          ///< left or right of a straight path
  kParallel,        ///< both straight, side by side
  kAlike,           ///< similar paths: two headings fit
  kDistance,        ///< the distance does not change
  kOffset,          ///< radio offset and position cannot be separated
  kSeveral,         ///< several poses fit, for none of the above reasons
  kLookAlike,       ///< the same, with evidence from scans only
  kContradict,      ///< unambiguous place recognitions contradict each other, and no other evidence
                    ///< exists
  kSlides,          ///< scans fit everywhere along a path, and no other evidence exists
  kNotYet,          ///< one pose fits, but with too large a sigma
  kHeight,          ///< height between the two is unobservable
  kMisfit,          ///< no pose fits: ranges contradict odometry
  kTooGood,         ///< residuals far smaller than their sigmas: the sigmas are wrong
  kNoPrior,         ///< preset paper needs a start pose
  kSmallMap,        ///< preset paper waits for keyframes
  kDrift,           ///< would suffice without the drift of odometry
  kFewViews         ///< only scans constrain it, and too few are unambiguous
};

/// Observability of a transform. The eigenvalues, in units of CommitSettings (1 deg, 0.1 m), assume
/// exact odometry; the sigmas include its drift.
struct Observability {
  int ranges = 0;
  Eigen::Vector3d eigenvalues = Eigen::Vector3d::Zero();   ///< of (yaw, x, y), ascending
  Eigen::Matrix3d eigenvectors = Eigen::Matrix3d::Zero();  ///< columns; scaled units
  double yaw_sigma_rad = 0.0, place_sigma_m = 0.0, z_sigma_m = 0.0;
  bool heading_known = false;
  bool sufficient = false;
  int rivals = 0;                         ///< besides the best, not yet rejected
  double rival_m = 0.0, rival_rad = 0.0;  ///< distance of the first of them to the best
  Advice advice = Advice::kNoContact;
  bool a_stands = false, b_stands = false;
};

/// Evaluates the best hypothesis and its rivals.
[[nodiscard]] Observability observability(const HypothesisSet& set, const InitSettings& settings);

/// The eigenvalues of (yaw, x, y) of an information on (yaw, position), scaled; z marginalised.
[[nodiscard]] Eigen::Matrix3d scaled_planar_information(const Mat4& information,
                                                        const CommitSettings& settings);

/// One or two sentences for the user: what is missing between vehicles a and b, and what to do.
[[nodiscard]] std::string advice_text(Advice advice, const Observability& seen,
                                      const std::string& a, const std::string& b,
                                      const InitSettings& settings);

}  // namespace rali::fleet
