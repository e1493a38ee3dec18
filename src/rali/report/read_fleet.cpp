#include <algorithm>

#include <fmt/format.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"
#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

constexpr std::uint64_t kSettingsBytesMax = 4ULL << 20;
constexpr std::size_t kSettingsMax = 1000;

std::vector<float> column(const io::CloudFile& cloud, const char* name, const char* other) {
  int field = cloud.field(name);
  if (field < 0) field = cloud.field(other);
  if (field < 0) return {};
  const std::vector<double> values = cloud.column(field);
  std::vector<float> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(),
                 [](double v) { return static_cast<float>(v); });
  return out;
}

/// "key: value   # origin" apart; a '#' in quotes does not occur before the origin's.
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

void read_fleet_tables(const std::string& dir, Time t_begin, RunData& run) {
  read_table(dir, "ranges.csv", run, [&](const TableRow& row) {
    run.range_rows.push_back({row.seconds("stamp_s", t_begin), row.text("from"), row.text("to"),
                              row.text("reason"), row.number("range_m"), row.number("residual_m"),
                              row.number("sigma_m"), row.flag("used")});
  });
  read_table(dir, "rounds.csv", run, [&](const TableRow& row) {
    run.rounds.push_back({row.text("round"), row.text("anchor"), row.text("ended_by"),
                          row.text("next_anchor"), row.seconds("start_s", t_begin),
                          row.seconds("end_s", t_begin)});
  });
  read_table(dir, "loops.csv", run, [&](const TableRow& row) {
    run.loops.push_back({row.text("vehicle_from"), row.text("vehicle_to"), row.text("reason"),
                         row.seconds("stamp_from_s", t_begin), row.seconds("stamp_to_s", t_begin),
                         row.number("score"), row.number("shift_m"), row.flag("accepted")});
  });
}

void read_map(const std::string& dir, RunData& run) {
  std::string name = "map.pcd";
  if (!file_exists(dir + '/' + name)) name = "map.ply";
  if (!file_exists(dir + '/' + name)) return;
  const Result<io::CloudFile> cloud = io::read_cloud_file(dir + '/' + name);
  if (!cloud) {
    run.unreadable.push_back(fmt::format("{}: {}", name, cloud.error().what));
    return;
  }
  MapPoints& map = run.map;
  map.x_m = column(*cloud, "x", "x");
  map.y_m = column(*cloud, "y", "y");
  map.z_m = column(*cloud, "z", "z");
  if (map.y_m.size() != map.x_m.size() || map.z_m.size() != map.x_m.size()) map = {};
  map.sigma_m = column(*cloud, "sigma", "scalar_sigma");
  map.sigma_m.resize(map.size(), std::numeric_limits<float>::quiet_NaN());
  const std::vector<float> vehicle = column(*cloud, "vehicle", "scalar_vehicle");
  map.vehicle.resize(map.size(), 0);
  for (std::size_t i = 0; i < std::min(vehicle.size(), map.size()); ++i) {
    map.vehicle[i] = vehicle[i] >= 0.0F && vehicle[i] < 255.5F
                         ? static_cast<std::uint8_t>(vehicle[i])
                         : std::uint8_t{0};
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
