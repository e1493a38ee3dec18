#pragma once

#include <optional>

#include "rali/base/time.hpp"
#include "rali/ranging/range_use.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Checks the ranges of one pair of antennas without any pose: limits, impossible changes, a radio
/// that repeats one value (algorithms 4.3, step 1).
class RangeSanity {
 public:
  RangeSanity(const RangeLimits& limits, const SanitySettings& settings);

  /// @return why the range is rejected, or nothing. Takes the ranges of the pair in order of
  /// arrival. `sigma_m`: of the range. `rate_mps`: its predicted rate; NaN if that is not known,
  /// then equal values are never classified as frozen.
  ///
  /// A change is taken from the last sane range. `resync_count` ranges in a row that contradict it
  /// but agree with each other replace it. Otherwise one wrong reference would reject all later
  /// ranges.
  [[nodiscard]] std::optional<RangeReason> check(Time t, double range_m, double sigma_m,
                                                 double rate_mps);

 private:
  struct Point {
    Time t;
    double range_m = 0.0;
  };

  [[nodiscard]] bool agrees(const Point& a, const Point& b, double sigma_m) const;
  [[nodiscard]] bool is_jump(const Point& now, double sigma_m);
  [[nodiscard]] bool is_frozen(const Point& now, double rate_mps);

  RangeLimits limits_;
  SanitySettings settings_;
  std::optional<Point> sane_;      ///< the last one accepted
  std::optional<Point> rejected_;  ///< the last of those that contradict it
  int rejected_count_ = 0;         ///< that agree with each other
  std::optional<Point> repeated_;  ///< the last range, to count its repeats
  int repeats_ = 0;
  double should_have_moved_m_ = 0.0;
};

}  // namespace rali::ranging
