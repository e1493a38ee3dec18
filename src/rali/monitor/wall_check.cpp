#include "rali/monitor/wall_check.hpp"

#include <algorithm>

namespace rali::monitor {

namespace {

double ratio_of(std::size_t part, std::size_t of, int least) {
  if (of < static_cast<std::size_t>(least)) return 0.0;
  return static_cast<double>(part) / static_cast<double>(of);
}

}  // namespace

std::size_t judged(std::span<const WallSight> sights, const MonitorSettings& settings) {
  return static_cast<std::size_t>(
      std::count_if(sights.begin(), sights.end(),
                    [least = static_cast<std::size_t>(settings.looks_min)](const WallSight& s) {
                      return s.looks >= least;
                    }));
}

bool looks_through(std::span<const WallSight> sights, const MonitorSettings& settings) {
  return std::any_of(sights.begin(), sights.end(), [&](const WallSight& s) {
    return ratio_of(s.passes, s.looks, settings.looks_min) > settings.through_max_ratio;
  });
}

std::vector<SeenThrough> check_walls(std::span<const WallSight> sights,
                                     const MonitorSettings& settings) {
  constexpr double kJoin_s = 5.0;
  std::vector<SeenThrough> out;
  for (const WallSight& sight : sights) {
    const double through = ratio_of(sight.passes, sight.looks, settings.looks_min);
    const double seen = ratio_of(sight.made_passed, sight.made, settings.made_min);
    const double worst = std::max(through, seen);
    if (!(worst > settings.through_max_ratio)) continue;
    if (out.empty() || seconds_between(out.back().when.end, sight.t) > kJoin_s) {
      out.push_back({{sight.t, sight.t}, 0.0, false});
    }
    SeenThrough& stretch = out.back();
    stretch.when.end = sight.t;
    stretch.ratio = std::max(stretch.ratio, worst);
    stretch.looks |= through > settings.through_max_ratio;
  }
  return out;
}

}  // namespace rali::monitor
