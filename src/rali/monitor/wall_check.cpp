#include "rali/monitor/wall_check.hpp"

#include <algorithm>
#include <optional>

namespace rali::monitor {

namespace {

double ratio_of(std::size_t part, std::size_t of, int minimum) {
  if (of < static_cast<std::size_t>(minimum)) return 0.0;
  return static_cast<double>(part) / static_cast<double>(of);
}

/// Keyframes of one interval are at most this far apart.
constexpr double kJoin_s = 5.0;

/// Ratio of passed walls to those in view of a keyframe; 0 if it is within the limit.
struct Through {
  double all = 0.0, others = 0.0;

  Through(const WallSight& sight, const MonitorSettings& settings)
      : all(ratio_of(sight.passes, sight.looks, settings.looks_min)),
        others(ratio_of(sight.others_passes, sight.others_looks, settings.others_looks_min)) {
    if (!(all > settings.through_max_ratio)) all = 0.0;
    if (!(others > settings.through_others_max_ratio)) others = 0.0;
  }

  [[nodiscard]] double maximum() const { return std::max(all, others); }

  /// Far beyond a limit.
  [[nodiscard]] bool is_clear(const MonitorSettings& settings) const {
    constexpr double kClear = 2.0;
    return all > kClear * settings.through_max_ratio ||
           others > kClear * settings.through_others_max_ratio;
  }
};

/// Of each keyframe. A wrong pose puts the next keyframe beside its place, too: one alone that is
/// little beyond a limit has looked into a mirror, or through panes of glass.
std::vector<Through> throughs(std::span<const WallSight> lines_of_sight,
                              const MonitorSettings& settings) {
  std::vector<Through> out;
  for (const WallSight& sight : lines_of_sight) out.emplace_back(sight, settings);
  std::optional<std::size_t> last, alone;
  const auto drop_alone = [&] {
    if (alone && !out[*alone].is_clear(settings)) out[*alone].all = out[*alone].others = 0.0;
  };
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!(out[i].maximum() > 0.0)) continue;
    const bool joins =
        last && seconds_between(lines_of_sight[*last].t, lines_of_sight[i].t) <= kJoin_s;
    if (!joins) drop_alone();
    alone = joins ? std::nullopt : std::optional(i);
    last = i;
  }
  drop_alone();
  return out;
}

}  // namespace

std::size_t judged(std::span<const WallSight> lines_of_sight, const MonitorSettings& settings) {
  return static_cast<std::size_t>(
      std::count_if(lines_of_sight.begin(), lines_of_sight.end(),
                    [minimum = static_cast<std::size_t>(settings.looks_min)](const WallSight& s) {
                      return s.looks >= minimum;
                    }));
}

bool looks_through(std::span<const WallSight> lines_of_sight, const MonitorSettings& settings) {
  const std::vector<Through> all = throughs(lines_of_sight, settings);
  return std::any_of(all.begin(), all.end(), [](const Through& t) { return t.maximum() > 0.0; });
}

MonitorSettings settings_for(std::span<const std::vector<WallSight>> vehicles,
                             const MonitorSettings& settings) {
  const auto lookers = std::count_if(
      vehicles.begin(), vehicles.end(), [&](const std::vector<WallSight>& lines_of_sight) {
        const std::vector<Through> all = throughs(lines_of_sight, settings);
        return std::any_of(all.begin(), all.end(), [](const Through& t) { return t.others > 0.0; });
      });
  MonitorSettings out = settings;
  if (lookers < 2) out.through_others_max_ratio = 1.0;
  return out;
}

std::vector<SeenThrough> check_walls(std::span<const WallSight> lines_of_sight,
                                     const MonitorSettings& settings) {
  const std::vector<Through> all = throughs(lines_of_sight, settings);
  std::vector<SeenThrough> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const WallSight& sight = lines_of_sight[i];
    const Through& looks = all[i];
    const double seen = ratio_of(sight.made_passed, sight.made, settings.made_min);
    const double worst = std::max(looks.maximum(), seen > settings.through_max_ratio ? seen : 0.0);
    if (!(worst > 0.0)) continue;
    if (out.empty() || seconds_between(out.back().when.end, sight.t) > kJoin_s ||
        seconds_between(out.back().when.begin, sight.t) > settings.part_max_s) {
      out.push_back({{sight.t, sight.t}, 0.0, false});
    }
    SeenThrough& stretch = out.back();
    stretch.when.end = sight.t;
    stretch.ratio = std::max(stretch.ratio, worst);
    stretch.looks |= looks.maximum() > 0.0;
    stretch.of_others |= looks.others > 0.0;
  }
  return out;
}

}  // namespace rali::monitor
