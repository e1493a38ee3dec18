#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "rali/report/internal/colours.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/plot/axis.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr double kLeft = 110.0, kWidth = 760.0, kRight = 12.0, kRow = 22.0;
constexpr std::size_t kRowsMax = 60;

std::string groups_html(const RunData& run) {
  if (run.vehicles.size() < 2) return absent("One vehicle: there is nothing to join.");
  if (run.groups.empty()) return absent("Which vehicles share a frame is not known.");
  Table table({"frame", "vehicles"});
  for (std::size_t i = 0; i < run.groups.size(); ++i) {
    table.row({fmt::format("{}", i + 1), names_text(run.groups[i])});
  }
  return table.html(true);
}

std::string time_axis(const Range& t, double left, double width, double y) {
  std::string out;
  const double step = tick_step(t.width(), 8);
  for (const double tick : ticks_of(t, 8)) {
    const double x = left + (tick - t.low()) / t.width() * width;
    fmt::format_to(
        std::back_inserter(out),
        "<path class=\"grid\" d=\"M{0:.1f} 4V{1:.1f}\"/><text x=\"{0:.1f}\" y=\"{2:.1f}\" "
        "class=\"mid\">{3}</text>",
        x, y, y + 13.0, tick_text(tick, step));
  }
  return out + fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid axis\">time [s]</text>\n",
                           left + 0.5 * width, y + 28.0);
}

/// Who stands as anchor when: one row per vehicle.
std::string roles_svg(const RunData& run) {
  Range t;
  t.add(0.0);
  t.add(last_time_s(run));
  for (const Round& r : run.rounds) t.add(r.end_s);
  t = t.widened(0.0, 1.0);
  const double width = kWidth - kLeft - kRight;
  const double bottom = 6.0 + kRow * static_cast<double>(run.vehicles.size());
  std::string out = fmt::format(
      "<svg class=\"plot\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" "
      "aria-label=\"roles over time\">\n",
      kWidth, bottom + 34.0);
  out += time_axis(t, kLeft, width, bottom);
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    const double y = 6.0 + kRow * static_cast<double>(i);
    fmt::format_to(std::back_inserter(out),
                   "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"end\">{}</text>", kLeft - 8.0, y + 13.0,
                   escaped(v.name));
    const auto bar = [&](double a, double b, const char* css_class, const std::string& words) {
      const double x = kLeft + (std::max(a, t.low()) - t.low()) / t.width() * width;
      const double w = (std::min(b, t.high()) - std::max(a, t.low())) / t.width() * width;
      if (!(w > 0.0)) return;
      fmt::format_to(std::back_inserter(out),
                     "<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"15\">"
                     "<title>{}</title></rect>",
                     css_class, x, y + 2.0, w, words);
      if (std::string_view(css_class) == "role-anchor" && w > 42.0) {
        fmt::format_to(std::back_inserter(out),
                       "<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"mid "
                       "on-dark\">anchor</text>",
                       x + 0.5 * w, y + 13.5);
      }
    };
    if (!v.way.empty()) bar(v.way.front().t_s, v.way.back().t_s, "role-drives", "drives");
    for (const Round& r : run.rounds) {
      if (r.anchor != v.name) continue;
      bar(r.begin_s, r.end_s, "role-anchor",
          fmt::format("round {}: anchor from {} to {} s", escaped(r.round), fixed(r.begin_s, 1),
                      fixed(r.end_s, 1)));
    }
    out += '\n';
  }
  return out + "</svg>\n";
}

std::string rounds_html(const RunData& run) {
  if (run.rounds.empty()) return absent("No rounds: nobody had to stand as anchor.");
  std::string html = "<figure>" + roles_svg(run) + "</figure>\n";
  Table table({"round", "anchor", "from", "to", "ended by", "next anchor"});
  for (std::size_t i = 0; i < std::min(run.rounds.size(), kRowsMax); ++i) {
    const Round& r = run.rounds[i];
    table.row({escaped(r.round), escaped(r.anchor), fixed(r.begin_s, 1) + " s",
               fixed(r.end_s, 1) + " s", escaped(r.ended_by), escaped(r.next_anchor)});
  }
  return html + table.html(true);
}

std::string loops_html(const RunData& run) {
  if (run.loops.empty()) return absent("No place was found again: no loop was closed or refused.");
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

}  // namespace

Section fleet_section(const RunData& run) {
  if (run.vehicles.size() < 2 && run.rounds.empty() && run.loops.empty()) {
    return {
        "fleet", "Fleet",
        absent(
            "One vehicle, no rounds, and no place was found again: nothing to join or to close.")};
  }
  return {"fleet", "Fleet",
          "<h3>Frames</h3>" + groups_html(run) + "<h3>Rounds and roles</h3>" + rounds_html(run) +
              "<h3>Loops</h3>" + loops_html(run)};
}

}  // namespace rali::report
