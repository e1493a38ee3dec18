#include "table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "rali/eval/statistics.hpp"

namespace rali::fleet_bench {

namespace {

using Group = std::vector<const Scores*>;

struct Column {
  const char* title;
  std::function<double(const Scores&)> get;
  int digits;
  bool low_is_bad = false;
};

const std::vector<Column>& columns() {
  static const std::vector<Column> kColumns{
      {"fleet APE m", [](const Scores& s) { return s.ape_m; }, 3},
      {"largest m", [](const Scores& s) { return s.ape_max_m; }, 3},
      {"worst vehicle alone m", [](const Scores& s) { return s.alone_m; }, 3},
      {"frame m", [](const Scores& s) { return s.frame_m; }, 3},
      {"frame deg", [](const Scores& s) { return s.frame_deg; }, 2},
      {"NEES 6", [](const Scores& s) { return s.nees6; }, 1},
      {"in 95 %", [](const Scores& s) { return s.fraction95; }, 2, true},
      {"cloud to mesh m", [](const Scores& s) { return s.mesh_m; }, 4},
      {"centre s", [](const Scores& s) { return s.centre_s; }, 1},
      {"MB/min", [](const Scores& s) { return s.mb_per_min; }, 2}};
  return kColumns;
}

/// Runs grouped by scene and row, in the order of their first run.
std::vector<Group> groups_of(const std::vector<Scores>& runs) {
  std::vector<Group> groups;
  for (const Scores& run : runs) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return g.front()->scene == run.scene && g.front()->row == run.row;
    });
    if (same == groups.end()) {
      groups.push_back({&run});
    } else {
      same->push_back(&run);
    }
  }
  return groups;
}

std::string heading(const char* first) {
  std::string titles = fmt::format("| {} |", first), line = "|---|";
  for (const Column& c : columns()) {
    titles += fmt::format(" {} |", c.title);
    line += "---|";
  }
  return titles + " joined | wrongly | loops | refused | wrong |\n" + line +
         "---|---|---|---|---|\n";
}

/// Sums over several runs.
std::string counts_text(const Group& group) {
  std::size_t joined = 0, vehicles = 0, wrongly = 0;
  LoopCount loops;
  for (const Scores* s : group) {
    joined += s->joined - 1;
    vehicles += s->vehicles - 1;
    wrongly += s->wrong_joins;
    loops.accepted += s->loops.accepted;
    loops.refused += s->loops.refused;
    loops.wrong += s->loops.wrong;
  }
  return fmt::format(" {}/{} | {} | {} | {} | {} |\n", joined, vehicles, wrongly, loops.accepted,
                     loops.refused, loops.wrong);
}

std::string number(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

std::string summary_table(const std::vector<Group>& groups) {
  std::string out = heading("median / worst");
  for (const Group& group : groups) {
    out += fmt::format("| {} {} ({}) |", group.front()->scene, group.front()->row, group.size());
    for (const Column& c : columns()) {
      std::vector<double> values;
      for (const Scores* s : group) {
        if (!std::isnan(c.get(*s))) values.push_back(c.get(*s));
      }
      if (values.empty()) {
        out += " - |";
        continue;
      }
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      out += fmt::format(" {:.{}f} / {:.{}f} |", eval::quantile(values, 0.5), c.digits,
                         c.low_is_bad ? *low : *high, c.digits);
    }
    out += counts_text(group);
  }
  return out;
}

/// Traffic does not depend on the fleet mapper: it is taken from the first row of each scene.
std::string traffic_table(const std::vector<Group>& groups) {
  std::string out =
      "\n| facts of a vehicle | messages per min | bytes each | MB per min |\n|---|---|---|---|\n";
  std::vector<std::string> scenes;
  for (const Group& group : groups) {
    const std::string& scene = group.front()->scene;
    if (std::find(scenes.begin(), scenes.end(), scene) != scenes.end()) continue;
    scenes.push_back(scene);
    fleet::TrafficCount all;
    double minutes = 0.0;
    for (const Scores* s : group) {
      all.add(s->traffic);
      minutes += static_cast<double>(s->vehicles) * s->duration_s / 60.0;
    }
    for (std::uint8_t k = 0; k < fleet::kFactKinds; ++k) {
      const auto kind = static_cast<fleet::Kind>(k);
      const auto& row = all[kind];
      if (row.messages == 0) continue;
      const auto bytes = static_cast<double>(row.bytes);
      const auto messages = static_cast<double>(row.messages);
      out += fmt::format("| {} {} | {:.1f} | {:.0f} | {:.3f} |\n", scene, fleet::name_of(kind),
                         messages / minutes, bytes / messages, 1e-6 * bytes / minutes);
    }
  }
  return out;
}

std::string waits_text(const std::vector<Group>& groups) {
  std::string out;
  for (const Group& group : groups) {
    for (const Scores* s : group) {
      for (const std::string& sentence : s->waits_for) {
        out += fmt::format("- {} {}, seed {}: \"{}\"\n", s->scene, s->row, s->seed, sentence);
      }
    }
  }
  return out.empty() ? out : "\nNot joined, and what the centre says:\n\n" + out;
}

}  // namespace

std::string tables_of(const std::vector<Scores>& runs) {
  const std::vector<Group> groups = groups_of(runs);
  return summary_table(groups) + traffic_table(groups) + waits_text(groups);
}

std::string run_table(const std::vector<Scores>& runs) {
  std::string out = heading("run");
  for (const Scores& s : runs) {
    out += fmt::format("| {} {} {} |", s.scene, s.row, s.seed);
    for (const Column& c : columns()) out += fmt::format(" {} |", number(c.get(s), c.digits));
    out += counts_text({&s});
  }
  return out;
}

std::string line_of(const Scores& s) {
  std::string line = fmt::format(
      "{} {} {}: {}/{} joined, APE {} m (alone {}), frame {} m {} deg, loops {}/{} ({} wrong), "
      "{:.1f} s",
      s.scene, s.row, s.seed, s.joined, s.vehicles, number(s.ape_m, 3), number(s.alone_m, 3),
      number(s.frame_m, 3), number(s.frame_deg, 2), s.loops.accepted, s.loops.refused,
      s.loops.wrong, s.centre_s);
  for (const std::string& how : s.decided_by) line += ", by " + how;
  for (const std::string& sentence : s.waits_for) line += "; " + sentence;
  return line;
}

}  // namespace rali::fleet_bench
