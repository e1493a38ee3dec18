#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/svg_plot.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kMeasuredMax = 400;

Plot plot_of(const RunData& run, std::string title, std::string unit) {
  Plot plot;
  plot.title = std::move(title);
  plot.y_label = fmt::format("[{}]", unit);
  plot.y_unit = unit;
  plot.width = 560.0;
  plot.height = 160.0;
  plot.x_min = 0.0;
  plot.x_max = last_time_s(run);
  return plot;
}

template <class Value>
void add_series(const RunData& run, Plot& plot, Value&& value) {
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    Series s{run.vehicles[i].name, {}, {}, style_of(i)};
    for (const ErrorPoint& e : run.vehicles[i].errors) {
      s.x.push_back(e.t_s);
      s.y.push_back(value(e));
    }
    plot.series.push_back(std::move(s));
  }
}

std::string plots(const RunData& run) {
  Plot ape = plot_of(run, "position error", "m");
  ape.y_min = 0.0;
  add_series(run, ape, [](const ErrorPoint& e) { return e.ape_m; });
  Plot rotation = plot_of(run, "rotation error", "deg");
  rotation.y_min = 0.0;
  add_series(run, rotation, [](const ErrorPoint& e) { return e.rot_deg; });
  Plot height = plot_of(run, "error in height", "m");
  add_series(run, height, [](const ErrorPoint& e) { return e.e_m.z(); });
  Plot blind = plot_of(run, "error along the blind axis", "m");
  add_series(run, blind, [](const ErrorPoint& e) { return e.along_blind_m; });
  Plot nees = plot_of(run, "NEES", "1");
  nees.log_y = true;
  add_series(run, nees, [](const ErrorPoint& e) { return e.nees; });
  std::string html = "<div class=\"plots\">";
  for (const Plot* plot : {&ape, &rotation, &height, &blind, &nees}) {
    if (const std::string svg = svg_of(*plot); !svg.empty()) html += "<figure>" + svg + "</figure>";
  }
  return html + "</div>\n";
}

}  // namespace

Section truth_section(const RunData& run) {
  Section section{"truth", "Against the truth", ""};
  const bool errors = std::any_of(run.vehicles.begin(), run.vehicles.end(),
                                  [](const VehicleView& v) { return !v.errors.empty(); });
  if (!run.evaluated() && !errors) {
    section.html = absent("No truth: the run was not evaluated (rali evaluate).");
    return section;
  }
  if (errors) section.html += plots(run);
  Table table({"measure", "value"});
  for (std::size_t i = 0; i < std::min(run.evaluation.size(), kMeasuredMax); ++i) {
    const Measured& m = run.evaluation[i];
    table.row({"<code>" + escaped(m.key) + "</code>", escaped(m.text)});
  }
  if (!table.empty())
    section.html += "<details><summary>All numbers of evaluation.json</summary>" + table.html() +
                    "</details>\n";
  return section;
}

}  // namespace rali::report
