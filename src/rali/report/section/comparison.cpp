#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

using Cell = std::string;

std::vector<std::string> head_of(const std::vector<RunData>& runs, const char* first) {
  std::vector<std::string> head = {first};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    head.push_back(fmt::format("{} {}", i + 1, escaped(runs[i].name)));
  }
  return head;
}

template <class Get>
void add_row(const std::vector<RunData>& runs, Table& table, std::string name, Get&& get) {
  std::vector<Cell> row = {std::move(name)};
  for (const RunData& run : runs) row.push_back(get(run));
  table.row(std::move(row));
}

std::vector<std::string> vehicle_names(const std::vector<RunData>& runs) {
  std::vector<std::string> names;
  for (const RunData& run : runs) {
    for (const VehicleView& v : run.vehicles) {
      if (std::find(names.begin(), names.end(), v.name) == names.end()) names.push_back(v.name);
    }
  }
  return names;
}

const VehicleNumbers* numbers_of(const RunData& run, const std::string& name) {
  for (const VehicleView& v : run.vehicles) {
    if (v.name == name) return &v.numbers;
  }
  return nullptr;
}

void add_vehicle_rows(const std::vector<RunData>& runs, Table& table) {
  for (const std::string& name : vehicle_names(runs)) {
    const auto add = [&](const char* what, Number VehicleNumbers::*member, auto text) {
      add_row(runs, table, fmt::format("{}: {}", escaped(name), what), [&](const RunData& run) {
        const VehicleNumbers* n = numbers_of(run, name);
        return text(n == nullptr ? Number() : n->*member);
      });
    };
    add("path", &VehicleNumbers::path_m, [](const Number& n) { return metres(n); });
    add("keyframes", &VehicleNumbers::keyframes, [](const Number& n) { return counted(n); });
    add("scans dropped", &VehicleNumbers::scans_dropped,
        [](const Number& n) { return counted(n); });
    add("degenerate", &VehicleNumbers::degenerate_fraction,
        [](const Number& n) { return percent(n); });
    add("of that constrained by ranges", &VehicleNumbers::degenerate_held_fraction,
        [](const Number& n) { return percent(n); });
    add("expected error, median", &VehicleNumbers::sigma_median_m,
        [](const Number& n) { return metres(n); });
    add("expected error, largest", &VehicleNumbers::sigma_max_m,
        [](const Number& n) { return metres(n); });
    add("diverged", &VehicleNumbers::diverged_s,
        [](const Number& n) { return fixed(n, 1) + " s"; });
  }
}

Section metrics_section(const std::vector<RunData>& runs) {
  Table table(head_of(runs, "measure"));
  add_row(runs, table, "status", [](const RunData& r) { return escaped(r.status); });
  add_row(runs, table, "program", [](const RunData& r) { return escaped(r.version); });
  add_row(runs, table, "data", [](const RunData& r) { return fixed(r.duration_s, 1) + " s"; });
  add_row(runs, table, "frames",
          [](const RunData& r) { return fmt::format("{}", r.groups.size()); });
  add_row(runs, table, "map points", [](const RunData& r) { return counted(r.map_points); });
  add_row(runs, table, "map thickness", [](const RunData& r) { return metres(r.map_thickness_m); });
  add_row(runs, table, "loops closed", [](const RunData& r) { return counted(r.loops_accepted); });
  add_row(runs, table, "ranges used", [](const RunData& r) { return counted(r.ranges.used); });
  add_row(runs, table, "against truth (APE rmse)",
          [](const RunData& r) { return metres(truth_error(r)); });
  add_row(runs, table, "largest error against truth",
          [](const RunData& r) { return metres(largest_error(r)); });
  add_row(runs, table, "NEES of the position (should be 3)", [](const RunData& r) {
    return fixed(measured(r, "fleet.trajectory.nees_position.mean"), 1);
  });
  add_row(runs, table, "map to the true surface, mean",
          [](const RunData& r) { return metres(measured(r, "cloud.to_mesh.mean_m")); });
  add_row(runs, table, "warnings",
          [](const RunData& r) { return fmt::format("{}", r.warnings.size()); });
  add_vehicle_rows(runs, table);
  return {"metrics", "Numbers side by side", "<div class=\"wide\">" + table.html() + "</div>"};
}

/// Each vehicle's paths in all runs; page_data groups them by its name.
Section overlay_section(const std::vector<RunData>& runs) {
  std::string html;
  for (const std::string& name : vehicle_names(runs)) {
    const auto has_path = [&](const RunData& run) {
      return std::any_of(run.vehicles.begin(), run.vehicles.end(),
                         [&](const VehicleView& v) { return v.name == name && !v.path.empty(); });
    };
    if (std::none_of(runs.begin(), runs.end(), has_path)) continue;
    const bool in_first =
        std::any_of(runs.front().vehicles.begin(), runs.front().vehicles.end(),
                    [&](const VehicleView& v) { return v.name == name && v.in_map; });
    html +=
        fmt::format("<h3>{0}</h3><figure data-figure=\"map\" data-group=\"{0}\"{1}></figure>\n",
                    escaped(name), in_first && runs.front().map.size() > 0 ? " data-cloud" : "");
  }
  if (html.empty()) return {"overlay", "Paths", absent("No run has a trajectory.")};
  return {"overlay", "Paths",
          html +
              "<p class=\"note\">As each run wrote them, nothing was aligned: a map begins at the "
              "first pose, z up. Wide marks along a path: degenerate. Points: the map of the first "
              "run, where the vehicle is in it.</p>\n"};
}

Section difference_section(const std::vector<RunData>& runs) {
  std::map<std::string, std::vector<std::string>> values;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (const SettingLine& s : runs[i].settings) {
      std::vector<std::string>& row = values[s.key];
      row.resize(runs.size());
      row[i] = s.value;
    }
  }
  Table table(head_of(runs, "setting"));
  for (const auto& [key, row] : values) {
    const std::vector<std::string>& all = row;
    if (std::all_of(all.begin(), all.end(), [&](const std::string& v) { return v == all[0]; })) {
      continue;
    }
    std::vector<Cell> cells = {"<code>" + escaped(key) + "</code>"};
    for (const std::string& v : row)
      cells.push_back(v.empty() ? "default" : "<code>" + escaped(v) + "</code>");
    table.row(std::move(cells));
  }
  return {
      "settings", "Settings that differ",
      table.empty() ? absent("The settings other than default are the same.") : table.html(true)};
}

Section speeds_section(const std::vector<RunData>& runs) {
  Table table(head_of(runs, "speed and memory"));
  add_row(runs, table, "time", [](const RunData& r) { return fixed(r.timing.total_s, 1) + " s"; });
  add_row(runs, table, "times real time",
          [](const RunData& r) { return fixed(r.timing.speed, 1); });
  add_row(runs, table, "memory",
          [](const RunData& r) { return counted(r.timing.memory_max_mb) + " MiB"; });
  return {"speed", "Speed and memory", table.html()};
}

}  // namespace

std::vector<Section> comparison_sections(const std::vector<RunData>& runs) {
  return {metrics_section(runs), overlay_section(runs), difference_section(runs),
          speeds_section(runs)};
}

}  // namespace rali::report
