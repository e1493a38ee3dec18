#include "rali/monitor/wall_check.hpp"

#include <algorithm>

namespace rali::monitor {

std::vector<SeenThrough> check_walls(std::span<const WallSight> sights,
                                     const MonitorSettings& settings) {
  constexpr double kJoin_s = 5.0;
  std::vector<SeenThrough> out;
  for (const WallSight& sight : sights) {
    if (sight.looks < static_cast<std::size_t>(settings.looks_min)) continue;
    const double through = static_cast<double>(sight.passes) / static_cast<double>(sight.looks);
    if (!(through > settings.through_max_ratio)) continue;
    if (out.empty() || seconds_between(out.back().when.end, sight.t) > kJoin_s) {
      out.push_back({{sight.t, sight.t}, 0.0});
    }
    out.back().when.end = sight.t;
    out.back().ratio = std::max(out.back().ratio, through);
  }
  return out;
}

}  // namespace rali::monitor
