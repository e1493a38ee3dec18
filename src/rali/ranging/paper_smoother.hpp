#pragma once

#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/ranging/paper_settings.hpp"

namespace rali::ranging {

/// A range read from a fit to the last ones.
struct SmoothedRange {
  Time t;
  double range_m = 0.0;
  double variance_m2 = 0.0;  ///< of white errors alone; neighbours have most samples in common
  int samples = 0;           ///< that took part
};

/// The paper's smoother (algorithms 4.2, T8): a line fitted to the ranges of the last seconds of
/// one pair of antennas, read at the newest. Irregular times by normal equations; samples far from
/// the line are removed once. A moving average is `mean`: it lags by half its length times the
/// speed.
class PaperRangeSmoother {
 public:
  explicit PaperRangeSmoother(const PaperRangeSettings& settings);

  /// Adds the next range of the pair. After a gap of more than half the length, or if time runs
  /// backward, it starts anew. A range that is not finite is left out: nothing.
  std::optional<SmoothedRange> add(Time t, double range_m);

  /// Starts anew: another anchor, a link that was lost.
  void reset() { samples_.clear(); }

 private:
  struct Sample {
    Time t;
    double range_m;
  };

  void make_room(Time t);
  [[nodiscard]] std::vector<Sample> without_outliers() const;

  PaperRangeSettings settings_;
  std::vector<Sample> samples_;
};

}  // namespace rali::ranging
