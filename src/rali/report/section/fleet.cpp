#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "rali/base/heading.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kRowsMax = 60;

/// How each vehicle's start pose was initialised, and its uncertainty.
std::string placed_html(const RunData& run) {
  Table table({"vehicle", "placed by", "place (1 sigma)", "heading (1 sigma)", "waits for"});
  for (const FleetFrame& f : run.frames) {
    if (f.decided_by.empty() && f.waits_for.empty()) continue;
    const bool placed = !f.decided_by.empty();
    constexpr double kDegPerRad = 57.29577951308232;
    const bool has_heading = placed && f.sigma_rad && heading_is_known(*f.sigma_rad);
    table.row({escaped(f.vehicle), placed ? escaped(f.decided_by) : "not placed",
               placed && f.sigma_m ? metres(f.sigma_m) : fixed(kUnknown, 0),
               has_heading ? fixed(*f.sigma_rad * kDegPerRad, 2) + "\xC2\xB0" : fixed(kUnknown, 0),
               escaped(f.waits_for)});
  }
  if (table.empty()) return {};
  return table.html(true) +
         "<p class=\"note\">Of the vehicle's first pose in the frame of the first vehicle.</p>\n";
}

std::string groups_html(const RunData& run) {
  if (run.vehicles.size() < 2) return absent("One vehicle: there is nothing to join.");
  if (run.groups.empty()) return absent("Which vehicles share a frame is not known.");
  if (run.groups.size() == 1) {
    return "<p>All in one frame: " + names_text(run.groups[0]) + ".</p>\n" + placed_html(run);
  }
  Table table({"frame", "vehicles", "in map.*"});
  for (std::size_t i = 0; i < run.groups.size(); ++i) {
    const auto& group = run.groups[i];
    const bool in_map = std::any_of(run.vehicles.begin(), run.vehicles.end(), [&](const auto& v) {
      return v.in_map && std::find(group.begin(), group.end(), v.name) != group.end();
    });
    table.row({fmt::format("{}", i + 1), names_text(group), in_map ? "yes" : "no"});
  }
  return table.html(true) + placed_html(run);
}

constexpr std::string_view kRoles =
    "<p class=\"legend\"><span><i data-kind=\"drives\"></i> drives</span><span><i "
    "data-kind=\"stands\"></i> stands</span><span><i data-kind=\"anchor\"></i> stands as "
    "anchor</span></p>\n<figure data-figure=\"roles\"></figure>\n";

std::string end_words(const std::string& ended_by) {
  static constexpr std::array<std::array<std::string_view, 2>, 7> kWords = {
      {{"finished", "all others had finished"},
       {"timeout", "its time was over"},
       {"anchor_moved", "the anchor drove off"},
       {"anchor_lost", "the anchor was lost"},
       {"explored", "nothing left to explore"},
       {"operator", "the user's table"},
       {"end_of_data", "the data ended"}}};
  for (const auto& [word, words] : kWords) {
    if (word == ended_by) return std::string(words);
  }
  return escaped(ended_by);
}

std::string rounds_html(const RunData& run) {
  if (run.rounds.empty()) return absent("No rounds are recorded.");
  std::string html(kRoles);
  Table table({"round", "anchor", "from", "to", "ended by", "next anchor"});
  for (std::size_t i = 0; i < std::min(run.rounds.size(), kRowsMax); ++i) {
    const Round& r = run.rounds[i];
    table.row({escaped(r.round), escaped(r.anchor), fixed(r.start_s, 1) + " s",
               fixed(r.end_s, 1) + " s", end_words(r.ended_by), escaped(r.next_anchor)});
  }
  html += table.html(true);
  if (run.rounds.size() > kRowsMax) {
    html += fmt::format("<p class=\"note\">and {} more in rounds.csv</p>\n",
                        run.rounds.size() - kRowsMax);
  }
  return html;
}

/// Results of the loop closures between two vehicles, or within one.
struct PairLoops {
  std::size_t accepted = 0, refused = 0;
  std::vector<double> scores, shifts_m;  ///< of those accepted
};

double median(std::vector<double> values) {
  values.erase(
      std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }),
      values.end());
  if (values.empty()) return kUnknown;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string metres_or_none(double value_m) {
  return std::isfinite(value_m) ? metres(value_m) : fixed(kUnknown, 0);
}

std::string pairs_html(const RunData& run) {
  std::map<std::pair<std::string, std::string>, PairLoops> pairs;
  for (const Loop& l : run.loops) {
    PairLoops& pair = pairs[std::minmax(l.vehicle_from, l.vehicle_to)];
    ++(l.accepted ? pair.accepted : pair.refused);
    if (!l.accepted) continue;
    pair.scores.push_back(l.score);
    if (std::isfinite(l.shift_m)) pair.shifts_m.push_back(l.shift_m);
  }
  Table table({"vehicles", "closed", "refused", "score, median", "shift, median", "largest"});
  for (const auto& [names, pair] : pairs) {
    const auto maximum = std::max_element(pair.shifts_m.begin(), pair.shifts_m.end());
    table.row({names.first == names.second
                   ? fmt::format("{} with itself", escaped(names.first))
                   : fmt::format("{} and {}", escaped(names.first), escaped(names.second)),
               fmt::format("{}", pair.accepted), fmt::format("{}", pair.refused),
               fixed(median(pair.scores), 2), metres_or_none(median(pair.shifts_m)),
               metres_or_none(maximum == pair.shifts_m.end() ? kUnknown : *maximum)});
  }
  return table.html() +
         "<p class=\"note\">Score: fraction of points that agree. Shift: how far the scans moved "
         "the "
         "two places against what was expected. All loops are in loops.csv.</p>\n";
}

std::string loops_html(const RunData& run) {
  if (run.loops.empty()) return absent("No loop was closed and none was refused.");
  std::string html = pairs_html(run);
  Table table({"refused: from", "to", "why", "score", "shift"});
  std::size_t refused = 0;
  for (const Loop& l : run.loops) {
    if (l.accepted || ++refused > kRowsMax) continue;
    table.row({fmt::format("{} at {} s", escaped(l.vehicle_from), fixed(l.from_s, 1)),
               fmt::format("{} at {} s", escaped(l.vehicle_to), fixed(l.to_s, 1)),
               escaped(l.reason), fixed(l.score, 2), metres_or_none(l.shift_m)});
  }
  if (refused == 0) return html;
  html += table.html(true);
  if (refused > kRowsMax) {
    html += fmt::format("<p class=\"note\">and {} more in loops.csv</p>\n", refused - kRowsMax);
  }
  return html;
}

std::string round_words(const std::string& round) {
  return round == "0" ? "end of data" : escaped(round);
}

/// Number of frontiers at the end of each round.
std::string frontier_counts_html(const RunData& run) {
  Table table({"when round ended", "open", "longest open", "explored", "unreachable", "too small"});
  for (std::size_t begin = 0; begin < run.frontiers.size() && table.size() < kRowsMax;) {
    std::map<std::string, std::size_t> states;
    double longest_m = kUnknown;
    std::size_t end = begin;
    for (; end < run.frontiers.size() && run.frontiers[end].round == run.frontiers[begin].round;
         ++end) {
      const Frontier& f = run.frontiers[end];
      ++states[f.state];
      if (f.state == "open" && !(f.length_m <= longest_m)) longest_m = f.length_m;
    }
    table.row({round_words(run.frontiers[begin].round), fmt::format("{}", states["open"]),
               metres_or_none(longest_m), fmt::format("{}", states["explored"]),
               fmt::format("{}", states["unreachable"]), fmt::format("{}", states["too_small"])});
    begin = end;
  }
  return table.lean_html();
}

std::string frontiers_html(const RunData& run) {
  if (run.frontiers.empty()) return {};
  const std::string& last = run.frontiers.back().round;
  Table table({"frontier", "at x", "y", "length", "nearest", "state", "why"});
  std::size_t left = 0;
  for (const Frontier& f : run.frontiers) {
    // Frontiers that are too small are numerous, and explored ones are done.
    if (f.round != last || f.state == "too_small" || f.state == "explored") continue;
    if (++left > kRowsMax) continue;
    table.row({escaped(f.id), fixed(f.p_m.x(), 1) + " m", fixed(f.p_m.y(), 1) + " m",
               metres_or_none(f.length_m), escaped(f.nearest_vehicle), escaped(f.state),
               escaped(f.reason)});
  }
  std::string html = "<h3>Frontiers: borders of what was seen</h3>" + frontier_counts_html(run);
  if (left == 0) return html + "<p>None was left to drive to.</p>\n";
  html += "<p>Left in the end:</p><div class=\"wide\">" + table.html(true) + "</div>";
  if (left > kRowsMax) {
    html += fmt::format("<p class=\"note\">and {} more in frontiers.csv</p>\n", left - kRowsMax);
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
