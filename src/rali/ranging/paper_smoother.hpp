#pragma once

#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/ranging/paper_settings.hpp"

namespace rali::ranging {

/// A range read from a fit to the last ranges.
struct SmoothedRange {
  Time t;
  double range_m = 0.0;
  double variance_m2 = 0.0;  ///< of white errors alone; neighbours share most of their samples
  int samples = 0;           ///< that took part
};

/// The paper's smoother (algorithms 4.2, T8): a line fitted to the ranges of the last seconds of
/// one pair of antennas, evaluated at the newest. Normal equations allow irregular times; samples
/// far from the line are removed once. Setting `mean` is a moving average: it lags by half its
/// length times the speed.
class PaperRangeSmoother {
 public:
  explicit PaperRangeSmoother(const PaperRangeSettings& settings);

  /// Adds the next range of the pair. After a gap of more than half the length, or if time runs
  /// backward, the fit starts anew. A range that is not finite is left out: returns nothing.
  std::optional<SmoothedRange> add(Time t, double range_m);

  /// Starts anew, for another anchor or after a lost link.
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
