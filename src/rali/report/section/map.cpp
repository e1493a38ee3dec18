#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "rali/report/data/cloud.hpp"
#include "rali/report/internal/colours.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/degenerate.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

template <class Is>
bool any_in_map(const RunData& run, Is&& is) {
  return std::any_of(run.vehicles.begin(), run.vehicles.end(),
                     [&](const VehicleView& v) { return v.in_map && is(v); });
}

bool degenerate_held_by(const VehicleView& v, HeldBy by) {
  return std::any_of(v.degeneracy.begin(), v.degeneracy.end(), [&](const DegeneracyPoint& d) {
    return d.degenerate && std::max(d.held_by, HeldBy::kRange) == by;
  });
}

std::string key(std::string_view shape, std::string_view words) {
  return fmt::format(
      "<span><svg width=\"34\" height=\"12\" viewBox=\"0 0 34 12\">{}</svg> {}</span>", shape,
      words);
}

/// Key of the drawing except the paths, which are labelled in it: at most six entries.
std::string map_legend(const RunData& run) {
  using Key = std::array<std::string_view, 2>;
  constexpr std::array<Key, 3> kHeld = {
      {{"d55e0080\" stroke-dasharray=\"3 5", "degenerate, constrained by ranges"},
       {"d55e00b0\" stroke-dasharray=\"12 7", "degenerate, constrained by inertia alone"},
       {"c0161d", "degenerate, constrained by nothing"}}};
  std::string out = "<p class=\"legend\">";
  for (std::size_t i = kHeld.size(); i-- > 0;) {
    const auto by = static_cast<HeldBy>(i + 1);
    if (!any_in_map(run, [&](const VehicleView& v) { return degenerate_held_by(v, by); })) continue;
    out += key(fmt::format("<path d=\"M2 6H32\" stroke-width=\"9\" stroke=\"#{}\"/>", kHeld[i][0]),
               kHeld[i][1]);
  }
  if (any_in_map(run, [](const VehicleView& v) { return !v.truth.empty(); })) {
    out += key(fmt::format("<path d=\"M0 6H34\" stroke-width=\"2.6\" stroke-dasharray=\"3 3\" "
                           "stroke=\"{}\"/>",
                           css(kTruthColour)),
               "ground truth");
  }
  if (!run.rounds.empty()) {
    out += key("<path d=\"M17 0l6 11h-12z\" fill=\"#1c2430\"/>", "stands as anchor");
  }
  if (!run.frontiers.empty()) {
    out += key("<path d=\"M17 1l5 5l-5 5l-5 -5z\" fill=\"#fff\" stroke=\"#14181f\"/>",
               "frontier left at the end");
  }
  return out + "</p>\n";
}

/// Selector for the colour of the points, with the key of each choice.
std::string colour_choice(const RunData& run) {
  const Span error = span_of_sigma(run.map), z = span_of_points(run.map, 2);
  std::string options, keys, bar = "linear-gradient(90deg";
  for (int i = 0; i <= 8; ++i) bar += ", " + css(scale_colour(i / 8.0, false));
  bar += ")";
  const auto add = [&](std::string_view name, std::string_view words, const std::string& key_html) {
    options += fmt::format("<option value=\"{}\">{}</option>", name, words);
    keys += fmt::format("<span data-colour=\"{}\"{}>{}</span>", name, keys.empty() ? "" : " hidden",
                        key_html);
  };
  const auto scale = [&](double left_m, double right_m) {
    return fmt::format("{} <i class=\"bar\" style=\"background:{}\"></i> {}", metres(left_m), bar,
                       metres(right_m));
  };
  if (error.known) {
    add("sigma", "expected error (1 sigma)", scale(error.high, error.low) + ", dark is worse");
  }
  add("height", "height z", scale(z.low, z.high));
  if (run.vehicles.size() > 1) add("vehicle", "vehicle", "the colour of its path");
  return fmt::format(
      "<label>points by <select class=\"cloud-colour\">{}</select></label> <span "
      "class=\"keys\">{}</span>",
      options, keys);
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

/// Paths of vehicles that are not joined: each group separately.
std::string other_frames(const RunData& run) {
  std::string html;
  for (std::size_t i = 0; i < run.groups.size(); ++i) {
    const std::vector<std::string>& group = run.groups[i];
    const bool has_path =
        std::any_of(run.vehicles.begin(), run.vehicles.end(), [&](const VehicleView& v) {
          return !v.in_map && !v.path.empty() &&
                 std::find(group.begin(), group.end(), v.name) != group.end();
        });
    if (!has_path) continue;
    html += fmt::format(
        "<figure><figcaption>{}, in a frame of {} own</figcaption><div data-figure=\"map\" "
        "data-group=\"frame{}\" data-height=\"360\"></div></figure>",
        names_text(group), group.size() == 1 ? "its" : "their", i);
  }
  if (html.empty()) return {};
  return "<h3>Paths that are not joined to the map</h3><div class=\"plots\">" + html + "</div>\n";
}

}  // namespace

Section map_section(const RunData& run) {
  Section section{"map", "Map", ""};
  const bool paths = any_in_map(run, [](const VehicleView& v) { return !v.path.empty(); });
  if (run.map.size() == 0 && !paths) {
    section.html = absent("There is no map and no trajectory.") + other_frames(run);
    return section;
  }
  const bool cloud = run.map.size() > 0;
  section.html = frames_note(run) + map_legend(run);
  if (cloud) section.html += "<p class=\"tools\">" + colour_choice(run) + "</p>\n";
  section.html += fmt::format(
      "<figure data-figure=\"map\" data-group=\"map\"{}></figure>\n<p class=\"note\">From above, "
      "in "
      "the frame of the map: x right, y up, origin at the first pose. Ring: start of a path; "
      "square: its end. {}Drag to zoom, double click for the whole map; the pointer on a path "
      "shows "
      "that time in all plots of the vehicle.</p>\n<h3>From the side</h3><figure "
      "data-figure=\"side\"></figure>\n",
      cloud ? " data-cloud" : "",
      cloud ? "What stands upright is dark, floors and ceilings are "
              "faint. "
            : "");
  section.html +=
      "<h3>Where the LiDAR was degenerate</h3>" + degenerate_html(run) + other_frames(run);
  return section;
}

Section view3d_section(const RunData& run) {
  Section section{"view", "Map in 3-D", ""};
  if (run.map.size() == 0) {
    section.html = absent("There is no map.pcd or map.ply with points.");
    return section;
  }
  section.html = fmt::format(
      "<p class=\"tools\">{} <label>cut at <input type=\"range\" id=\"view3d-cut\" min=\"1\" "
      "max=\"100\" value=\"75\"> of the height</label> <button id=\"view3d-home\">whole "
      "map</button></p>\n<div data-figure=\"view\" class=\"view3d\"></div>\n<p "
      "class=\"note\">Drag to turn, right button to move, click and wheel to zoom. Orange: the "
      "LiDAR was degenerate. A part of the map's {} points is drawn; map.ply holds all.</p>\n",
      colour_choice(run), counted(static_cast<double>(run.map_file_points)));
  return section;
}

}  // namespace rali::report
