#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "rali/geometry/types.hpp"
#include "rali/ranging/paper_settings.hpp"

namespace rali::ranging {

/// Input of the paper's correction. All in one frame with z up.
struct CorrectionInput {
  geometry::Vec3 p_m = geometry::Vec3::Zero();  ///< of the antenna, or of the body as in the paper
  geometry::Vec3 anchor_m = geometry::Vec3::Zero();  ///< the same point of the peer
  double range_m = 0.0;                              ///< smoothed
  geometry::Vec3 e3 = geometry::Vec3::UnitX();  ///< degenerate direction; its sign does not matter
  bool degenerate = false;                      ///< whether any direction is degenerate
  std::optional<double> imu_s_m;  ///< position of the prediction on the line, for root nearest_imu
};

enum class CorrectionOutcome {
  kCorrected,
  kNotNeeded,         ///< not degenerate, or the range fits within gap_m
  kAmbiguous,         ///< two solutions of similar length: the anchor is abeam
  kInconsistent,      ///< the circle does not reach the line
  kTooSensitive,      ///< an error of the range would grow too much
  kDirectionUnknown,  ///< the degenerate direction is not horizontal enough
  kTooFar             ///< the correction is longer than allowed
};
inline constexpr ChoiceNames<7> kCorrectionOutcomeNames{
    "corrected",     "not_needed",        "ambiguous", "inconsistent",
    "too_sensitive", "direction_unknown", "too_far"};

struct Correction {
  CorrectionOutcome outcome = CorrectionOutcome::kNotNeeded;
  double s_m = 0.0;                                 ///< along the direction, 0 unless corrected
  geometry::Vec3 shift_m = geometry::Vec3::Zero();  ///< s times the direction; add to the position
  double gap_m = 0.0;  ///< distance to the anchor less the range, without sign
  double sensitivity = std::numeric_limits<double>::quiet_NaN();  ///< ds/du; infinite if touching
  bool closest = false;  ///< the circle only touches the line or misses it: log this
};

/// e3 projected on the horizontal plane and normalised; nothing if less than `minimum` is left.
[[nodiscard]] std::optional<geometry::Vec3> horizontal_direction(const geometry::Vec3& e3,
                                                                 double minimum);

/// The paper's correction, exactly (algorithms 5.2, T9): moves the position along the degenerate
/// direction onto the circle of the range. Rotation, velocity and covariance stay as they are.
/// Where the circle only touches or misses the line (`closest`), the sensitivity is infinite and
/// not checked: the position moves to the point of the line nearest to the anchor.
[[nodiscard]] Correction correct_on_circle(const CorrectionInput& input,
                                           const PaperRangeSettings& settings);

/// Distributes a shift at the end of a chain of keyframes among them: C_i / C_k of it, C the sum of
/// `variance_increments_m2` of odometry along the shift, up to and with i (algorithms 5.5, T10).
/// All zero if all increments are zero.
[[nodiscard]] std::vector<double> share_shift(std::span<const double> variance_increments_m2,
                                              double shift_m);

}  // namespace rali::ranging
