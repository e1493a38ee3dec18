#include <algorithm>

#include <fmt/format.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"
#include "rali/report/thinned_map.hpp"

namespace rali::report {
namespace {

constexpr std::uint64_t kSettingsBytesMax = 4ULL << 20;
constexpr std::size_t kSettingsMax = 1000;

/// Splits "key: value   # origin"; a '#' in quotes never follows the origin's.
void split_line(std::string_view line, std::string& key, std::string& value, std::string& origin) {
  const std::size_t comment = line.rfind("  # ");
  const std::size_t short_comment = line.rfind(" # ");
  const std::size_t at = comment != std::string_view::npos ? comment + 1 : short_comment;
  if (at != std::string_view::npos) {
    origin = std::string(io::trimmed(line.substr(at + 2)));
    line = line.substr(0, at);
  }
  const std::size_t colon = line.find(':');
  key = std::string(io::trimmed(line.substr(0, std::min(colon, line.size()))));
  if (colon != std::string_view::npos) value = std::string(io::trimmed(line.substr(colon + 1)));
}

}  // namespace

void read_fleet_tables(const std::string& dir, Time t_start, RunData& run) {
  read_table(dir, "rounds.csv", run, [&](const TableRow& row) {
    run.rounds.push_back({row.text("round"), row.text("anchor"), row.text("ended_by"),
                          row.text("next_anchor"), row.seconds("start_s", t_start),
                          row.seconds("end_s", t_start)});
  });
  read_table(dir, "frontiers.csv", run, [&](const TableRow& row) {
    run.frontiers.push_back({row.text("round"),
                             row.text("id"),
                             row.text("nearest_vehicle"),
                             row.text("state"),
                             row.text("reason"),
                             {row.number("x"), row.number("y"), kUnknown},
                             row.number("length_m")});
  });
  read_table(dir, "loops.csv", run, [&](const TableRow& row) {
    run.loops.push_back({row.text("vehicle_from"), row.text("vehicle_to"), row.text("reason"),
                         row.seconds("stamp_from_s", t_start), row.seconds("stamp_to_s", t_start),
                         row.number("score"), row.number("shift_m"), row.flag("accepted")});
  });
}

void read_map(const std::string& dir, RunData& run) {
  std::string name = "map.pcd";
  if (!file_exists(dir + '/' + name)) name = "map.ply";
  if (!file_exists(dir + '/' + name)) return;
  Result<ThinnedMap> map = read_thinned_map(dir + '/' + name);
  if (!map) {
    run.unreadable.push_back(fmt::format("{}: {}", name, map.error().what));
    return;
  }
  if (!map->note.empty()) run.unreadable.push_back(fmt::format("{} {}", name, map->note));
  run.map = std::move(map->points);
  run.map_file_points = map->points_in_file;
}

void find_frame_of_map(RunData& run) {
  if (run.groups.size() < 2) return;
  // Points refer to their vehicle by its index in the list; map.* holds the largest group.
  std::vector<std::size_t> points(run.vehicles.size(), 0);
  for (const std::uint8_t v : run.map.vehicle) {
    if (v < points.size()) ++points[v];
  }
  const auto weight = [&](const std::vector<std::string>& group) {
    double sum = 0.0;
    for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
      const VehicleView& v = run.vehicles[i];
      if (std::find(group.begin(), group.end(), v.name) == group.end()) continue;
      sum += run.map.size() > 0 ? static_cast<double>(points[i]) : v.numbers.keyframes.value_or(0);
    }
    return sum;
  };
  const auto best =
      std::max_element(run.groups.begin(), run.groups.end(),
                       [&](const auto& a, const auto& b) { return weight(a) < weight(b); });
  for (VehicleView& v : run.vehicles) {
    v.in_map = std::find(best->begin(), best->end(), v.name) != best->end();
  }
}

std::vector<SettingLine> settings_other_than_default(const std::string& text) {
  std::vector<SettingLine> lines;
  std::vector<std::string> path;
  std::string_view rest = text, line;
  while (io::take_line(rest, line) && lines.size() < kSettingsMax) {
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    if (indent == line.size() || line[indent] == '#') continue;
    SettingLine setting;
    split_line(line, setting.key, setting.value, setting.origin);
    path.resize(std::min(path.size(), indent / 2));
    path.push_back(setting.key);
    if (setting.origin.empty() || setting.origin == "default") continue;
    setting.key.clear();
    for (const std::string& part : path) setting.key += (setting.key.empty() ? "" : ".") + part;
    lines.push_back(std::move(setting));
  }
  return lines;
}

void read_settings(const std::string& dir, RunData& run) {
  const std::string path = dir + "/settings.yaml";
  if (!file_exists(path)) return;
  const Result<std::vector<std::byte>> bytes = io::read_file(path, kSettingsBytesMax);
  if (!bytes) {
    run.unreadable.push_back("settings.yaml: " + bytes.error().what);
    return;
  }
  run.settings_known = true;
  run.settings = settings_other_than_default(std::string(io::as_text(*bytes)));
}

}  // namespace rali::report
