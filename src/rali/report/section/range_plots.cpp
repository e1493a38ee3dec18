#include "rali/report/section/range_plots.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/svg_plot.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// So few pairs have a plot as wide as the page.
constexpr std::size_t kPlotsMax = 12, kWideMax = 3;

struct Look {
  Rgb colour;
  Marker marker;
  double width;
};

/// Used ranges are light and small, rejected ones dark shapes: they differ on grey paper too.
constexpr std::array<Look, kRangeFateCount> kLooks = {{{{125, 172, 214}, Marker::kDot, 2.0},
                                                       {{178, 34, 0}, Marker::kCross, 1.3},
                                                       {{120, 40, 140}, Marker::kTriangle, 1.2},
                                                       {{30, 30, 30}, Marker::kSquare, 1.2},
                                                       {{0, 114, 88}, Marker::kDiamond, 1.2},
                                                       {{90, 98, 110}, Marker::kStake, 1.2},
                                                       {{150, 110, 0}, Marker::kDash, 1.2},
                                                       {{0, 90, 160}, Marker::kPlus, 1.2},
                                                       {{100, 60, 20}, Marker::kRing, 1.2},
                                                       {{140, 150, 160}, Marker::kRing, 1.0},
                                                       {{60, 120, 20}, Marker::kVee, 1.2},
                                                       {{190, 0, 110}, Marker::kStar, 1.2}}};

/// The largest |residual| drawn to scale: a few wild ranges must not flatten the rest.
double scale_of(const PairRanges& pair) {
  std::vector<double> sizes;
  for (const std::vector<RangeDot>& dots : pair.dots) {
    for (const RangeDot& dot : dots) {
      if (std::isfinite(dot.residual_m)) sizes.push_back(std::abs(dot.residual_m));
    }
  }
  if (sizes.empty()) return kUnknown;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 97 / 100);
  std::nth_element(sizes.begin(), at, sizes.end());
  return std::max(1.3 * *at, 0.05);
}

void add_series(const PairRanges& pair, std::size_t fate, Plot& plot) {
  const Look& look = kLooks[fate];
  Series known{std::string(fate_words(static_cast<RangeFate>(fate))), {}, {}, {look.colour, ""}};
  known.dots = true;
  known.width = look.width;
  known.marker = look.marker;
  Series bare = known;
  bare.on_rail = true;
  for (const RangeDot& dot : pair.dots[fate]) {
    if (std::isfinite(dot.residual_m)) {
      known.x.push_back(dot.t_s);
      known.y.push_back(dot.residual_m);
    } else {
      bare.x.push_back(dot.t_s);
    }
  }
  if (!bare.x.empty()) {
    plot.rail_label = "ranges without a residual: their prediction is not known";
    plot.series.push_back(std::move(bare));
  }
  if (!known.x.empty()) plot.series.push_back(std::move(known));
}

Plot residual_plot(const RunData& run, const PairRanges& pair, double scale_m) {
  Plot plot;
  plot.title = pair.a + "-" + pair.b;
  plot.y_label = "residual [m]";
  plot.y_unit = "m";
  const bool wide = run.range_table.pairs.size() <= kWideMax;
  plot.width = wide ? 760.0 : 440.0;
  plot.height = wide ? 200.0 : 160.0;
  plot.x_min = 0.0;
  plot.x_max = last_time_s(run);
  plot.y_max = scale_m;
  plot.y_min = -scale_m;
  plot.marks.push_back({0.0, ""});
  // The ranges used come first: the rejected ones are drawn over them.
  for (std::size_t fate = 0; fate < kRangeFateCount; ++fate) add_series(pair, fate, plot);
  return plot;
}

/// "no range of v1-v2 has a residual: 389 no pose at that time"
std::string without_residual(const PairRanges& pair) {
  std::string found;
  for (std::size_t i = 0; i < kRangeFateCount; ++i) {
    if (pair.count[i] == 0) continue;
    found += fmt::format("{}{} {}", found.empty() ? "" : ", ",
                         counted(static_cast<double>(pair.count[i])),
                         fate_words(static_cast<RangeFate>(i)));
  }
  return fmt::format("<p class=\"note\">{}-{}: no range has a residual ({}).</p>\n",
                     escaped(pair.a), escaped(pair.b), found);
}

}  // namespace

std::string range_plots_html(const RunData& run) {
  const std::vector<PairRanges>& pairs = run.range_table.pairs;
  if (pairs.empty()) return {};
  std::string plots, notes;
  for (std::size_t i = 0; i < std::min(pairs.size(), kPlotsMax); ++i) {
    const double scale_m = scale_of(pairs[i]);
    if (!std::isfinite(scale_m)) {
      notes += without_residual(pairs[i]);
      continue;
    }
    const std::string svg = svg_of(residual_plot(run, pairs[i], scale_m));
    if (!svg.empty()) plots += "<figure>" + svg + "</figure>";
  }
  std::string html;
  if (!plots.empty()) {
    html =
        "<p class=\"note\">Residual: measured less predicted range, after the bias. Marks at the "
        "border lie farther out; marks in the strip below the frame have no residual. Where many "
        "lie on one place, one is drawn.</p>\n" +
        (pairs.size() <= kWideMax ? plots : "<div class=\"plots\">" + plots + "</div>") + "\n";
  }
  html += notes;
  if (pairs.size() > kPlotsMax) {
    html += fmt::format("<p class=\"note\">{} of {} pairs are drawn; all are in ranges.csv.</p>\n",
                        kPlotsMax, pairs.size());
  }
  return html;
}

}  // namespace rali::report
