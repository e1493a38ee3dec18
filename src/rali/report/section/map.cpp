#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/map_view.hpp"
#include "rali/report/section/blind.hpp"
#include "rali/report/section/blind_map.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

void add_ways(const RunData& run, MapView& view) {
  for (const VehicleView& v : run.vehicles) {
    if (v.truth.empty() || !v.in_map) continue;
    view.ways.push_back({v.name + " truth", &v.truth, Style{kTruthColour, "3 3"}, {}, 2.6, false});
  }
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    if (v.way.empty() || !v.in_map) continue;
    view.ways.push_back({v.name, &v.way, style_of(i), blind_stretches(v), 2.2});
  }
}

void add_frontiers(const RunData& run, MapView& view) {
  std::string last;
  for (const Frontier& f : run.frontiers) last = f.round;
  for (const Frontier& f : run.frontiers) {
    const bool left = f.state != "explored" && f.state != "too_small";
    if (f.round != last || !left || !f.p_m.head<2>().allFinite()) continue;
    view.frontiers.push_back(
        {f.p_m, fmt::format("frontier {}: {}, {:.1f} m", f.id, f.state, f.length_m)});
  }
}

void add_anchors(const RunData& run, MapView& view) {
  for (const Round& round : run.rounds) {
    for (const VehicleView& v : run.vehicles) {
      if (v.name != round.anchor || !v.in_map) continue;
      const WayPoint* where = pose_near(v.way, 0.5 * (round.begin_s + round.end_s));
      if (where == nullptr) continue;
      view.anchors.push_back(
          {where->p_m, fmt::format("round {}: {} stands as anchor", round.round, v.name)});
    }
  }
}

MapView base_view(const RunData& run) {
  MapView view;
  view.map = &run.map;
  add_ways(run, view);
  add_blind_bars(run, view);
  add_frontiers(run, view);
  add_anchors(run, view);
  return view;
}

void colour_by_error(const RunData& run, MapView& view) {
  const ErrorScale scale = error_scale(run.map);
  if (!scale.known) return;
  view.share = [&map = run.map, scale](std::size_t i) {
    return scale.share(static_cast<double>(map.sigma_m[i]));
  };
  view.dark_is_high = true;
  view.colour_low = metres(scale.low_m);
  view.colour_high = metres(scale.high_m);
  view.colour_text = "expected error of the points (1 sigma); darker is worse";
}

void colour_by_height(const RunData& run, MapView& view) {
  const Range z = range_of_points(run.map, 2);
  if (z.empty()) return;
  const double low = z.low(), width = std::max(z.width(), 0.01);
  view.share = [&map = run.map, low, width](std::size_t i) {
    return (static_cast<double>(map.z_m[i]) - low) / width;
  };
  view.colour_low = metres(z.low());
  view.colour_high = metres(z.high());
  view.colour_text = "height z of the points";
}

/// Each point in the colour of the vehicle that saw it first; the ways have the same colours.
void colour_by_vehicle(const RunData& run, MapView& view) {
  view.share = [&map = run.map](std::size_t i) { return static_cast<double>(map.vehicle[i]); };
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) view.kinds.push_back(style_of(i).colour);
}

/// Seen from the side along the shorter of the two horizontal axes.
ViewAxes side_axes(const RunData& run) {
  Range x = range_of_points(run.map, 0), y = range_of_points(run.map, 1);
  for (const VehicleView& v : run.vehicles) {
    if (!v.in_map) continue;
    for (const WayPoint& w : v.way) {
      x.add(w.p_m.x());
      y.add(w.p_m.y());
    }
  }
  return x.width() >= y.width() ? ViewAxes{0, 2, 1} : ViewAxes{1, 2, 0};
}

std::string legend(const MapView& view) {
  std::string out = "<p class=\"legend\">";
  bool truth = false;
  for (const MapWay& way : view.ways) {
    // All truths are drawn alike.
    const bool is_truth = !way.ends;
    if (is_truth && std::exchange(truth, true)) continue;
    out += fmt::format(
        "<span><svg width=\"30\" height=\"8\"><path d=\"M0 4H30\" stroke=\"{}\" "
        "stroke-width=\"2.5\" stroke-dasharray=\"{}\"/></svg> {}</span>",
        css(way.style.colour), way.style.dash, is_truth ? "truth" : escaped(way.label));
  }
  out += blind_legend(view);
  if (!view.frontiers.empty()) {
    out +=
        "<span><svg width=\"14\" height=\"12\"><path class=\"frontier\" d=\"M7 1l5 5l-5 5l-5 "
        "-5z\"/>"
        "</svg> frontier left at the end</span>";
  }
  if (!view.anchors.empty()) {
    out +=
        "<span><svg width=\"14\" height=\"12\"><path class=\"anchor\" d=\"M7 1l6 10h-12z\"/>"
        "</svg> stands as anchor</span>";
  }
  return out + "<span>&#9675; begin &#9632; end of a way</span></p>\n";
}

std::vector<std::string> names_in(const RunData& run, bool in_map) {
  std::vector<std::string> names;
  for (const VehicleView& v : run.vehicles) {
    if (v.in_map == in_map) names.push_back(v.name);
  }
  return names;
}

std::string frames_note(const RunData& run) {
  const std::vector<std::string> others = names_in(run, false);
  if (others.empty()) return {};
  return fmt::format(
      "<p class=\"doubt\">Only the map of {} is shown: {} {} not joined to it. Where {} in it is "
      "not known.</p>\n",
      names_text(names_in(run, true)), names_text(others), others.size() == 1 ? "is" : "are",
      others.size() == 1 ? "that one stands" : "those stand");
}

/// Ways of vehicles that are not joined: each group by itself.
std::string other_frames(const RunData& run) {
  std::string html;
  for (const std::vector<std::string>& group : run.groups) {
    MapView view;
    for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
      const VehicleView& v = run.vehicles[i];
      if (v.in_map || v.way.empty()) continue;
      if (std::find(group.begin(), group.end(), v.name) == group.end()) continue;
      view.ways.push_back({v.name, &v.way, style_of(i), blind_stretches(v), 2.2});
    }
    view.width = 560.0;
    view.height_max = 360.0;
    const std::string svg = svg_of(view);
    if (svg.empty()) continue;
    html += fmt::format("<figure><figcaption>{}, in a frame of {} own</figcaption>{}</figure>",
                        names_text(group), group.size() == 1 ? "its" : "their", svg);
  }
  if (html.empty()) return {};
  return "<h3>Ways that are not joined to the map</h3><div class=\"plots\">" + html + "</div>\n";
}

}  // namespace

Section map_section(const RunData& run) {
  Section section{"map", "Map", ""};
  MapView top = base_view(run);
  MapView heights = top;
  colour_by_error(run, top);
  colour_by_height(run, heights);
  const std::string by_error = svg_of(top);
  if (by_error.empty()) {
    section.html = absent("There is no map and no trajectory.");
    return section;
  }
  section.html += frames_note(run) + legend(top);
  if (run.map.size() > 0 && top.share) {
    std::string labels, third;
    if (run.vehicles.size() > 1 && run.map.vehicle.size() == run.map.size()) {
      MapView vehicles = base_view(run);
      colour_by_vehicle(run, vehicles);
      labels =
          "<input type=\"radio\" name=\"top\" id=\"top-vehicle\"><label for=\"top-vehicle\">"
          "by vehicle</label>";
      third = "<figure class=\"c\">" + svg_of(vehicles) + "</figure>";
    }
    section.html += fmt::format(
        "<div class=\"switch\"><input type=\"radio\" name=\"top\" id=\"top-error\" checked>"
        "<label for=\"top-error\">by expected error</label><input type=\"radio\" name=\"top\" "
        "id=\"top-height\"><label for=\"top-height\">by height</label>{}"
        "<figure class=\"a\">{}</figure><figure class=\"b\">{}</figure>{}</div>\n",
        labels, by_error, svg_of(heights), third);
  } else {
    section.html += "<figure>" + svg_of(run.map.size() > 0 ? heights : top) + "</figure>\n";
  }
  section.html +=
      "<p class=\"note\">From above, x of the map to the right and y up; the origin is "
      "the first pose. What stands upright is dark, floors and "
      "ceilings are faint.</p>\n";
  MapView side = top.share ? top : heights;
  side.axes = side_axes(run);
  side.height_max = 260.0;
  side.stretch_up = true;
  section.html += fmt::format("<h3>From the side</h3><figure>{}</figure>\n", svg_of(side));
  section.html += "<h3>Where the LiDAR was blind</h3>" + blind_html(run) + other_frames(run);
  return section;
}

}  // namespace rali::report
