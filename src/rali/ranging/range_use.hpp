#pragma once

#include <limits>

#include "rali/base/settings.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::ranging {

/// Outcome of one range, and its reason. Names as in ranges.csv.
enum class RangeReason {
  kUsed,
  kNlos,           ///< line of sight blocked, by signal, map or excess
  kOutlier,        ///< contradicts its neighbours in time
  kOutOfLimits,    ///< shorter or longer than the limits, or not a number
  kNoPose,         ///< the position of one of the two ends is not known
  kDuplicate,      ///< the other direction of an exchange already used, or a repeat
  kUnknownId,      ///< an end that is no vehicle of the fleet
  kLate,           ///< older than what the estimator still can use
  kBlockedByGate,  ///< does not fit the prediction within its covariance
  kNotNeeded,      ///< preset paper: not degenerate, it fitted well enough, or no keyframe came
  kBadGeometry,  ///< preset paper: across the degenerate direction it does not determine the shift
};
inline constexpr ChoiceNames<11> kRangeReasonNames{
    "used",       "nlos", "outlier",         "out_of_limits", "no_pose",     "duplicate",
    "unknown_id", "late", "blocked_by_gate", "not_needed",    "bad_geometry"};

/// One range and its outcome: a row of ranges.csv. NaN where a number is not known.
struct RangeUse {
  sensor::RangeSample sample;
  RangeReason reason = RangeReason::kNoPose;
  double predicted_m = std::numeric_limits<double>::quiet_NaN();  ///< bias included
  double residual_m = std::numeric_limits<double>::quiet_NaN();   ///< measured less predicted
  double sigma_m = std::numeric_limits<double>::quiet_NaN();      ///< of the residual as predicted
  double bias_m = std::numeric_limits<double>::quiet_NaN();       ///< of the pair, as estimated
  double p_los = std::numeric_limits<double>::quiet_NaN();        ///< probability of line of sight

  [[nodiscard]] bool used() const { return reason == RangeReason::kUsed; }
};

}  // namespace rali::ranging
