#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/config/load_fleet.hpp"
#include "rali/config/public_settings.hpp"
#include "rali/config/text_of.hpp"

namespace rali::config {
namespace {

constexpr std::string_view kIntroduction =
    R"(Keys of `fleet.yaml`, `v1` standing for each vehicle. The same keys go with `--set KEY=VALUE`, where
`settings.` may be left out. Later ones win: default, preset, carrier, file, command line. The
`settings.yaml` of a run names the origin of each value and is itself a valid `fleet.yaml`.
)";

constexpr std::string_view kPublicNames =
    "These settings keep their names. `rali help-settings --all` prints all others too; those are "
    "unstable:\nthey work in files and with `--set`, but may change with any release.\n";

constexpr std::string_view kAllNames =
    "Keys with (public) keep their names. All others are unstable: they may change with any "
    "release.\n";

constexpr std::string_view kNotes = R"(
## Notes

`settings.odometry.robust.carrier` sets defaults of `settings.odometry.robust.constraints`. `ground`: all
constraints, 2 m/s usual, 40 m/s and 8 m/s2 at most. `handheld`: without `non_holonomic` and `ground`;
1.5 m/s, 12 m/s, 15 m/s2. `drone`: without `standstill` as well, since a hovering drone is not at
standstill (set it to true where a drone lands as a range reference); 5 m/s, 60 m/s, 30 m/s2.

`ranges`, `radio`, `priors`, `rounds` and `antennas` are between vehicles: one vehicle alone does not use
them. `clock: offset` is checked but has no effect yet. A warning names keys without effect.

`serial_log` of `ranges.sources` is a CSV of what a LinkTrack radio sent over its serial port (Nodeframe2,
3, 5, Tagframe0): `stamp_s,hex`, a row for each read of the port with the time of its arrival and the bytes
in hexadecimal. Bytes without times of arrival cannot be used: the radio's clock starts when it is switched
on.

`output.georeference` is a CSV `vehicle,stamp_s,x_m,y_m,z_m,sigma_m`: the body of the vehicle stood over a
mark of known coordinates at that time. Three or more marks give yaw and translation (gravity levels the
map). Residuals stand in metrics.json under `site`, and map.las is written in site coordinates.
`output.frame` moves `trajectory/` from the body to the LiDAR or the IMU; all other files keep the body.
)";

/// One heading with its table.
struct Section {
  std::string heading;
  std::string advice;
  FieldList fields;
};

std::string group_of(const std::string& key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string::npos ? std::string() : key.substr(0, dot);
}

/// The public settings, by symptom.
std::vector<Section> by_symptom(const FieldList& all) {
  std::vector<Section> sections;
  for (const SymptomGroup& group : public_settings()) {
    Section section{std::string(group.symptom), std::string(group.advice), {}};
    for (const std::string_view key : group.keys) {
      const auto field =
          std::find_if(all.begin(), all.end(), [&](const Field& f) { return f.key == key; });
      if (field != all.end()) section.fields.push_back(*field);
    }
    sections.push_back(std::move(section));
  }
  return sections;
}

/// All settings, in the order of a file.
std::vector<Section> by_group(const FieldList& all) {
  std::vector<Section> sections;
  std::vector<std::string> groups;
  for (const Field& field : all) {
    const std::string group = group_of(field.key);
    const auto at = std::find(groups.begin(), groups.end(), group);
    const auto index = static_cast<std::size_t>(at - groups.begin());
    if (at == groups.end()) {
      groups.push_back(group);
      const std::string& help = field.group_help;
      sections.push_back(
          {(group.empty() ? "fleet.yaml" : group) + (help.empty() ? "" : ": " + help), {}, {}});
    }
    sections[index].fields.push_back(field);
    if (field.visibility == Visibility::kPublic) sections[index].fields.back().help += " (public)";
  }
  return sections;
}

}  // namespace

std::string settings_manual(SettingsShown shown) {
  FleetConfig config;
  config.vehicles.emplace_back();
  config.vehicles.back().recordings = {"v1.bag"};
  const FieldList all = fleet_fields(config, "");
  const bool some = shown == SettingsShown::kPublic;
  std::string text = fmt::format("# {}\n\nMade by `rali help-settings{}`; do not edit.\n\n{}\n{}",
                                 some ? "Settings" : "All settings", some ? "" : " --all",
                                 kIntroduction, some ? kPublicNames : kAllNames);
  for (const Section& section : some ? by_symptom(all) : by_group(all)) {
    text += fmt::format("\n## {}\n\n{}{}{}", section.heading, section.advice,
                        section.advice.empty() ? "" : "\n\n", manual_table(section.fields));
  }
  if (some) text += kNotes;
  return text;
}

}  // namespace rali::config
