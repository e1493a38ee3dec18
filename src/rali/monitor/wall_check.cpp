#include "rali/monitor/wall_check.hpp"

#include <algorithm>

namespace rali::monitor {

namespace {

double ratio_of(std::size_t part, std::size_t of, int least) {
  if (of < static_cast<std::size_t>(least)) return 0.0;
  return static_cast<double>(part) / static_cast<double>(of);
}

/// How much a keyframe looks through walls, as a ratio of those in view; 0 where that is usual.
struct Through {
  double all = 0.0, others = 0.0;

  Through(const WallSight& sight, const MonitorSettings& settings)
      : all(ratio_of(sight.passes, sight.looks, settings.looks_min)),
        others(ratio_of(sight.others_passes, sight.others_looks, settings.others_looks_min)) {
    if (!(all > settings.through_max_ratio)) all = 0.0;
    if (!(others > settings.through_others_max_ratio)) others = 0.0;
  }

  [[nodiscard]] double most() const { return std::max(all, others); }
};

}  // namespace

std::size_t judged(std::span<const WallSight> sights, const MonitorSettings& settings) {
  return static_cast<std::size_t>(
      std::count_if(sights.begin(), sights.end(),
                    [least = static_cast<std::size_t>(settings.looks_min)](const WallSight& s) {
                      return s.looks >= least;
                    }));
}

bool looks_through(std::span<const WallSight> sights, const MonitorSettings& settings) {
  return std::any_of(sights.begin(), sights.end(),
                     [&](const WallSight& s) { return Through(s, settings).most() > 0.0; });
}

MonitorSettings settings_for(std::span<const std::vector<WallSight>> vehicles,
                             const MonitorSettings& settings) {
  const auto lookers =
      std::count_if(vehicles.begin(), vehicles.end(), [&](const std::vector<WallSight>& sights) {
        return std::any_of(sights.begin(), sights.end(),
                           [&](const WallSight& s) { return Through(s, settings).others > 0.0; });
      });
  MonitorSettings out = settings;
  if (lookers < 2) out.through_others_max_ratio = 1.0;
  return out;
}

std::vector<SeenThrough> check_walls(std::span<const WallSight> sights,
                                     const MonitorSettings& settings) {
  constexpr double kJoin_s = 5.0;
  std::vector<SeenThrough> out;
  for (const WallSight& sight : sights) {
    const Through looks(sight, settings);
    const double seen = ratio_of(sight.made_passed, sight.made, settings.made_min);
    const double worst = std::max(looks.most(), seen > settings.through_max_ratio ? seen : 0.0);
    if (!(worst > 0.0)) continue;
    if (out.empty() || seconds_between(out.back().when.end, sight.t) > kJoin_s) {
      out.push_back({{sight.t, sight.t}, 0.0, false});
    }
    SeenThrough& stretch = out.back();
    stretch.when.end = sight.t;
    stretch.ratio = std::max(stretch.ratio, worst);
    stretch.looks |= looks.most() > 0.0;
    stretch.of_others |= looks.others > 0.0;
  }
  return out;
}

}  // namespace rali::monitor
