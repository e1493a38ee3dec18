#include "rali/report/plot/state_runs.hpp"

#include <algorithm>
#include <cmath>

namespace rali::report {

std::vector<StateRun> state_runs(const std::vector<StateSample>& samples, double end, double gap,
                                 std::size_t columns) {
  std::vector<StateRun> runs;
  if (!(end > 0.0) || !std::isfinite(end) || columns == 0) return runs;
  const double width = end / static_cast<double>(columns);
  // One more than the state; 0: nothing is known.
  std::vector<std::size_t> shown(columns, 0);
  const auto column = [&](double x) {
    return std::min(static_cast<std::size_t>(x / width), columns - 1);
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double x = samples[i].x;
    if (!(x >= 0.0 && x <= end)) continue;
    double to = i + 1 < samples.size() ? samples[i + 1].x : x;
    if (!(to >= x && to - x <= gap && to <= end)) to = x;
    // The column in which the next sample begins is the next sample's.
    const std::size_t first = column(x), last = std::max(first, to > x ? column(to) : first);
    for (std::size_t c = first; c < std::max(last, first + 1); ++c) {
      shown[c] = std::max(shown[c], samples[i].state + 1);
    }
  }
  for (std::size_t c = 0; c < columns; ++c) {
    if (shown[c] == 0) continue;
    const double begin = static_cast<double>(c) * width;
    const bool joins = c > 0 && shown[c - 1] == shown[c];
    if (!joins) runs.push_back({begin, begin, shown[c] - 1});
    runs.back().end = std::min(begin + width, end);
  }
  return runs;
}

}  // namespace rali::report
