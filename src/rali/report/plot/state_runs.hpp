#pragma once

#include <cstddef>
#include <vector>

namespace rali::report {

/// A stretch of x over which one state holds.
struct StateRun {
  double begin = 0.0, end = 0.0;
  std::size_t state = 0;
};

/// One sample: from `x` to the next sample's x the state holds.
struct StateSample {
  double x = 0.0;
  std::size_t state = 0;
};

/// Runs of equal states over 0 to `end`, at most one per column. Where several states meet in one
/// column the highest is shown: the states count from good to bad, and no bad one is hidden.
/// Nothing is shown between samples that are farther apart than `gap`. Samples outside of the span
/// and those that are no numbers are left out.
[[nodiscard]] std::vector<StateRun> state_runs(const std::vector<StateSample>& samples, double end,
                                               double gap, std::size_t columns);

}  // namespace rali::report
