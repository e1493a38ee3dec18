#include "rali/report/section/blind_map.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/blind_strip.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// More bars of expected error along a way would hide it.
constexpr double kBarsPerWay = 8.0;

std::string_view stretch_class(HeldBy by) {
  if (by == HeldBy::kNothing) return "by-nothing";
  return by == HeldBy::kImu ? "by-imu" : "by-range";
}

}  // namespace

std::vector<MapStretch> blind_stretches(const VehicleView& v) {
  constexpr std::size_t kColumns = 400;
  std::vector<MapStretch> list;
  for (const StateRun& run : blind_runs(v, kColumns)) {
    const auto by = static_cast<HeldBy>(run.state);
    list.push_back({run.begin, run.end, std::string(stretch_class(by)),
                    fmt::format("{} blind, {}, {:.1f} to {:.1f} s", v.name, held_words(by),
                                run.begin, run.end)});
  }
  return list;
}

void add_blind_bars(const RunData& run, MapView& view) {
  for (const VehicleView& v : run.vehicles) {
    if (!v.in_map || v.way.empty()) continue;
    const double stride_m = std::max(v.numbers.path_m.value_or(0.0), 1.0) / kBarsPerWay;
    double way_m = 0.0, next_m = 0.5 * stride_m;
    const WayPoint* before = nullptr;
    for (const DegeneracyPoint& d : v.degeneracy) {
      const WayPoint* p = pose_near(v.way, d.t_s);
      if (before != nullptr) way_m += (p->p_m - before->p_m).norm();
      before = p;
      if (way_m < next_m || !d.blind || !d.axis.allFinite()) continue;
      next_m = way_m + stride_m;
      const bool sized = std::isfinite(d.off_m);
      const std::string off =
          sized ? fmt::format("may be off by {:.2f} m along this axis (1 sigma)", d.off_m)
                : std::string("how far off it may be along this axis is not known");
      view.bars.push_back({p->p_m, d.axis, (sized ? d.off_m : 0.0) * d.axis,
                           fmt::format("{} at {:.0f} s: {}", v.name, d.t_s, off)});
    }
  }
}

std::string blind_legend(const MapView& view) {
  std::string out;
  for (const HeldBy by : {HeldBy::kNothing, HeldBy::kImu, HeldBy::kRange}) {
    const std::string_view kind = stretch_class(by);
    bool there = false;
    for (const MapWay& way : view.ways) {
      for (const MapStretch& stretch : way.blind) there |= stretch.css_class == kind;
    }
    if (!there) continue;
    out += fmt::format(
        "<span><svg width=\"34\" height=\"12\"><path class=\"blind-way {}\" d=\"M2 6H32\"/></svg> "
        "blind, {}</span>",
        kind, held_words(by));
  }
  const BarsShown shown = bars_shown(view);
  if (shown.arrows) {
    out +=
        "<span><svg width=\"30\" height=\"12\"><path class=\"axis-arrow\" d=\"M3 6H27M7 3L3 6l4 "
        "3M23 3l4 3l-4 3\"/></svg> blind axis</span>";
  }
  if (shown.bars) {
    out +=
        "<span><svg width=\"34\" height=\"14\"><path class=\"off\" d=\"M3 7H31M3 1v12M31 1v12\"/>"
        "</svg> blind axis, with how far off it may be (1 sigma, at the scale of the map)</span>";
  }
  return out;
}

}  // namespace rali::report
