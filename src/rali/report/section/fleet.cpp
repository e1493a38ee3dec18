#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/time_rows.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kRowsMax = 60;

std::string groups_html(const RunData& run) {
  if (run.vehicles.size() < 2) return absent("One vehicle: there is nothing to join.");
  if (run.groups.empty()) return absent("Which vehicles share a frame is not known.");
  if (run.groups.size() == 1) {
    return "<p>All in one frame: " + names_text(run.groups[0]) + ".</p>\n";
  }
  Table table({"frame", "vehicles", "in map.*"});
  for (std::size_t i = 0; i < run.groups.size(); ++i) {
    const auto& group = run.groups[i];
    const bool in_map = std::any_of(run.vehicles.begin(), run.vehicles.end(), [&](const auto& v) {
      return v.in_map && std::find(group.begin(), group.end(), v.name) != group.end();
    });
    table.row({fmt::format("{}", i + 1), names_text(group), in_map ? "yes" : "no"});
  }
  return table.html(true);
}

/// Who stands as anchor when: one row per vehicle.
std::string roles_svg(const RunData& run) {
  double end_s = last_time_s(run);
  for (const Round& r : run.rounds)
    end_s = std::isfinite(r.end_s) ? std::max(end_s, r.end_s) : end_s;
  std::vector<TimeRow> rows;
  for (const VehicleView& v : run.vehicles) {
    TimeRow row{v.name, {}};
    if (!v.way.empty()) {
      row.bars.push_back(
          {v.way.front().t_s, v.way.back().t_s, "role-drives", "drives", "", 0.0, 1.0});
    }
    for (const Round& r : run.rounds) {
      if (r.anchor != v.name) continue;
      row.bars.push_back({r.begin_s, r.end_s, "role-anchor",
                          fmt::format("round {}: anchor from {} to {} s", r.round,
                                      fixed(r.begin_s, 1), fixed(r.end_s, 1)),
                          "anchor", 0.0, 1.0});
    }
    rows.push_back(std::move(row));
  }
  return svg_of(rows, RowAxis{end_s, "time [s]", true}, "roles over time");
}

constexpr std::string_view kRoleLegend =
    "<p class=\"legend\"><span><svg width=\"24\" height=\"14\"><rect class=\"role-drives\" "
    "width=\"24\" height=\"14\"/></svg> drives</span><span><svg width=\"24\" height=\"14\"><rect "
    "class=\"role-anchor\" width=\"24\" height=\"14\"/></svg> stands as anchor</span></p>\n";

std::string rounds_html(const RunData& run) {
  if (run.rounds.empty()) return absent("No rounds are recorded.");
  std::string html = std::string(kRoleLegend) + "<figure>" + roles_svg(run) + "</figure>\n";
  Table table({"round", "anchor", "from", "to", "ended by", "next anchor"});
  for (std::size_t i = 0; i < std::min(run.rounds.size(), kRowsMax); ++i) {
    const Round& r = run.rounds[i];
    table.row({escaped(r.round), escaped(r.anchor), fixed(r.begin_s, 1) + " s",
               fixed(r.end_s, 1) + " s", escaped(r.ended_by), escaped(r.next_anchor)});
  }
  return html + table.html(true);
}

std::string state_words(const std::string& state) {
  return state == "too_small" ? "too small" : escaped(state);
}

std::string loops_html(const RunData& run) {
  if (run.loops.empty()) return absent("No loop was closed and none was refused.");
  Table table({"from", "to", "", "why", "score", "shift"});
  for (std::size_t i = 0; i < std::min(run.loops.size(), kRowsMax); ++i) {
    const Loop& l = run.loops[i];
    table.row({fmt::format("{} at {} s", escaped(l.vehicle_from), fixed(l.from_s, 1)),
               fmt::format("{} at {} s", escaped(l.vehicle_to), fixed(l.to_s, 1)),
               l.accepted ? "\xE2\x9C\x93 closed" : "\xE2\x9C\x97 refused", escaped(l.reason),
               fixed(l.score, 2),
               std::isfinite(l.shift_m) ? metres(l.shift_m) : fixed(kUnknown, 0)});
  }
  std::string html = table.html(true);
  if (run.loops.size() > kRowsMax) {
    html += fmt::format("<p class=\"note\">and {} more in loops.csv</p>\n",
                        run.loops.size() - kRowsMax);
  }
  return html;
}

std::string frontiers_html(const RunData& run) {
  if (run.frontiers.empty()) return {};
  std::map<std::string, std::size_t> states;
  const std::string& last = run.frontiers.back().round;
  for (const Frontier& f : run.frontiers) states[f.state] += f.round == last ? 1 : 0;
  std::string sum;
  for (const auto& [state, n] : states) {
    if (n == 0) continue;
    sum += fmt::format("{}{} {}", sum.empty() ? "" : ", ", n, state_words(state));
  }
  Table table({"round", "frontier", "at x", "y", "length", "nearest", "state", "why"});
  for (std::size_t i = 0; i < std::min(run.frontiers.size(), kRowsMax); ++i) {
    const Frontier& f = run.frontiers[i];
    table.row({escaped(f.round), escaped(f.id), fixed(f.p_m.x(), 1) + " m",
               fixed(f.p_m.y(), 1) + " m",
               std::isfinite(f.length_m) ? metres(f.length_m) : fixed(kUnknown, 0),
               escaped(f.nearest_vehicle), state_words(f.state), escaped(f.reason)});
  }
  std::string html = "<h3>Frontiers: borders of what was seen</h3><p>In the last round: " + sum +
                     ".</p>\n" + "<div class=\"wide\">" + table.html(true) + "</div>";
  if (run.frontiers.size() > kRowsMax) {
    html += fmt::format("<p class=\"note\">and {} more in frontiers.csv</p>\n",
                        run.frontiers.size() - kRowsMax);
  }
  return html;
}

}  // namespace

Section fleet_section(const RunData& run) {
  if (run.vehicles.size() < 2 && run.rounds.empty() && run.loops.empty() && run.frontiers.empty()) {
    return {
        "fleet", "Fleet",
        absent("One vehicle, no rounds, no loops: nothing to join, and no drift was taken out by "
               "coming back.")};
  }
  return {"fleet", "Fleet",
          "<h3>Frames</h3>" + groups_html(run) + "<h3>Rounds and roles</h3>" + rounds_html(run) +
              frontiers_html(run) + "<h3>Loops</h3>" + loops_html(run)};
}

}  // namespace rali::report
