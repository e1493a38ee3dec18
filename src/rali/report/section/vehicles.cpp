#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/axis.hpp"
#include "rali/report/plot/svg_plot.hpp"
#include "rali/report/section/blind_strip.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr double kPlotWidth = 440.0, kPlotHeight = 140.0;
constexpr std::size_t kColumns = 370;
/// Speed is the way of so much time: single poses are too noisy.
constexpr double kSpeedSpan_s = 1.0;
constexpr double kDegPerRad = 57.29577951308232;

Plot plot_of(const RunData& run, const VehicleView& v, std::string title, std::string unit) {
  Plot plot;
  plot.title = std::move(title);
  plot.y_unit = unit;
  plot.y_label = fmt::format("[{}]", unit);
  plot.width = kPlotWidth;
  plot.height = kPlotHeight;
  plot.x_min = 0.0;
  plot.x_max = last_time_s(run);
  for (const StateRun& blind : blind_runs(v, kColumns)) {
    plot.stretches.push_back(
        {blind.begin, blind.end,
         fmt::format("blind from {:.1f} to {:.1f} s, {}", blind.begin, blind.end,
                     held_words(static_cast<HeldBy>(blind.state)))});
  }
  return plot;
}

Series height_series(const VehicleView& v, Style style) {
  Series s{v.name, {}, {}, std::move(style)};
  for (const WayPoint& w : v.way) {
    s.x.push_back(w.t_s);
    s.y.push_back(w.p_m.z());
  }
  return s;
}

Series speed_series(const VehicleView& v, Style style) {
  Series s{v.name, {}, {}, std::move(style)};
  std::size_t back = 0;
  for (std::size_t i = 0; i < v.way.size(); ++i) {
    while (v.way[i].t_s - v.way[back].t_s > kSpeedSpan_s) ++back;
    const double span_s = v.way[i].t_s - v.way[back].t_s;
    if (span_s < 0.5 * kSpeedSpan_s) continue;
    s.x.push_back(0.5 * (v.way[i].t_s + v.way[back].t_s));
    s.y.push_back((v.way[i].p_m - v.way[back].p_m).norm() / span_s);
  }
  return s;
}

Series sigma_series(const VehicleView& v, Style style) {
  Series s{"expected (1 sigma)", {}, {}, std::move(style)};
  for (const SigmaPoint& p : v.sigmas) {
    s.x.push_back(p.t_s);
    s.y.push_back(p.sigma_m);
  }
  return s;
}

Series error_series(const VehicleView& v) {
  Series s{"measured", {}, {}, {kTruthColour, "3 2"}};
  for (const ErrorPoint& e : v.errors) {
    s.x.push_back(e.t_s);
    s.y.push_back(e.ape_m);
  }
  return s;
}

Series degree_series(const VehicleView& v, Style style) {
  Series s{v.name, {}, {}, std::move(style)};
  for (const DegeneracyPoint& d : v.degeneracy) {
    s.x.push_back(d.t_s);
    s.y.push_back(d.degree);
  }
  return s;
}

/// Direction of the weakest axis: heading in the map, -90 to 90 degrees; an axis has no sign.
Series axis_series(const VehicleView& v, bool blind_only, Style style) {
  Series s{blind_only ? "blind" : "seen", {}, {}, std::move(style), true, blind_only ? 4.0 : 2.0};
  for (const DegeneracyPoint& d : v.degeneracy) {
    if (!d.axis.allFinite() || d.axis.head<2>().norm() < 0.5 || d.blind != blind_only) continue;
    double heading = std::atan2(d.axis.y(), d.axis.x()) * kDegPerRad;
    if (heading > 90.0) heading -= 180.0;
    if (heading <= -90.0) heading += 180.0;
    s.x.push_back(d.t_s);
    s.y.push_back(heading);
  }
  return s;
}

std::string plots_of(const RunData& run, const VehicleView& v, const Style& style) {
  std::string html = "<div class=\"plots\">";
  Plot z = plot_of(run, v, "height z", "m");
  z.series.push_back(height_series(v, style));
  Plot speed = plot_of(run, v, "speed", "m/s");
  speed.series.push_back(speed_series(v, style));
  speed.y_min = 0.0;
  Plot sigma = plot_of(run, v, "position error", "m");
  sigma.series.push_back(sigma_series(v, style));
  if (!v.errors.empty()) sigma.series.push_back(error_series(v));
  sigma.y_min = 0.0;
  Plot degree = plot_of(run, v, "degree of degeneracy", "1");
  degree.y_label = "lambda2/lambda3";
  degree.log_y = true;
  degree.series.push_back(degree_series(v, style));
  Plot axis = plot_of(run, v, "heading of the weakest axis", "deg");
  axis.series.push_back(axis_series(v, false, {Rgb{150, 156, 166}, ""}));
  axis.series.push_back(axis_series(v, true, {kBlindColour, ""}));
  axis.y_min = -95.0;
  axis.y_max = 95.0;
  axis.y_step = 45.0;
  for (Plot* plot : {&z, &speed, &sigma, &degree, &axis}) {
    plot->legend = plot->series.size() > 1;
    if (plot->series.size() == 1) plot->series.front().label = plot->title;
    if (const std::string svg = svg_of(*plot); !svg.empty()) html += "<figure>" + svg + "</figure>";
  }
  return html + "</div>\n";
}

/// "0.0310 (stated 0.0300)", as measured while driving.
std::string noise_cell(const Number& measured, const Number& stated, int decimals) {
  if (!measured) return fixed(kUnknown, 0);
  return fmt::format("{} (stated {})", fixed(measured, decimals), fixed(stated, decimals));
}

std::string numbers_table(const RunData& run) {
  Table table({"vehicle", "path", "sweeps", "dropped", "keyframes", "blind", "held by ranges",
               "expected error, median", "worst", "diverged", "LiDAR clock off by", "accel. scale",
               "accel. noise [m/s2/rtHz]", "gyro noise [rad/s/rtHz]"});
  for (const VehicleView& v : run.vehicles) {
    const VehicleNumbers& n = v.numbers;
    table.row({escaped(v.name), metres(n.path_m), counted(n.sweeps), counted(n.sweeps_dropped),
               counted(n.keyframes), percent(n.blind_share),
               n.blind_share.value_or(0.0) > 0.0 ? percent(n.blind_held_share) : fixed(kUnknown, 0),
               metres(n.sigma_median_m), metres(n.sigma_max_m), fixed(n.diverged_s, 1) + " s",
               n.time_offset_s ? fixed(1e3 * *n.time_offset_s, 1) + " ms" : fixed(kUnknown, 0),
               fixed(n.accel_scale, 4), noise_cell(n.accel_noise, n.accel_noise_stated, 4),
               noise_cell(n.gyro_noise, n.gyro_noise_stated, 5)});
  }
  return "<div class=\"wide\">" + table.html() + "</div>";
}

}  // namespace

Section vehicles_section(const RunData& run) {
  Section section{"vehicles", "Vehicles", ""};
  if (run.vehicles.empty()) {
    section.html = absent("No vehicle left a pose.");
    return section;
  }
  section.html += numbers_table(run);
  section.html +=
      "<p class=\"note\">Expected error: 1 sigma of the position in space (root of the trace of "
      "its "
      "covariance), seen from where the map begins. Hatched: the LiDAR is blind along one axis. "
      "The degree is "
      "lambda2/lambda3 of the translation's eigenvalues: large where one direction is "
      "seen badly, 1 where all are seen alike. Headings count from x of the map.";
  if (run.evaluated()) {
    section.html += " Measured errors are those after the best fit of the whole way to the truth.";
  }
  section.html += "</p>\n";
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    section.html += fmt::format("<h3>{}</h3>\n", escaped(v.name));
    section.html += v.way.empty() ? absent("It has no trajectory.") : "";
    section.html += blind_strip_html(run, v, i);
    section.html += plots_of(run, v, {style_of(i).colour, ""});
  }
  return section;
}

}  // namespace rali::report
