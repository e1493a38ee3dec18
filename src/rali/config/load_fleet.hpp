#pragma once

#include <string>
#include <vector>

#include "rali/config/fleet_config.hpp"

namespace rali::config {

/// What the command line adds to a file.
struct Overrides {
  std::string preset;                    ///< --preset; empty: not given
  std::vector<std::string> assignments;  ///< of --set, KEY=VALUE, in order
  bool live = false;                     ///< sensors supply the data: no recording is needed
};

/// Reads a fleet.yaml (or the settings.yaml of a run). Increasing precedence: defaults, preset,
/// file, command line. `settings.` may be left out of a KEY: odometry.preset=paper.
/// Errors: kUsage with file:line (unknown key, value not allowed, no vehicle, no recording, names
/// that do not fit each other), kInput (the file cannot be read).
[[nodiscard]] Result<FleetConfig> load_fleet(const std::string& path, const Overrides& overrides);

/// The same from a text; relative paths in it are read against `base_dir`.
[[nodiscard]] Result<FleetConfig> parse_fleet(std::string_view text, const std::string& name,
                                              const std::string& base_dir,
                                              const Overrides& overrides);

/// The configuration of bare recordings: one vehicle each, named after the files. A folder with a
/// calib.yaml (a vehicle's section of fleet.yaml) is read with it.
/// Errors: as load_fleet; two recordings of one name.
[[nodiscard]] Result<FleetConfig> fleet_of_recordings(const std::vector<std::string>& inputs,
                                                      const Overrides& overrides);

/// The configuration of vehicles of which only the names are known.
/// Errors: as load_fleet.
[[nodiscard]] Result<FleetConfig> fleet_of_names(const std::vector<std::string>& names,
                                                 const Overrides& overrides);

/// A fleet.yaml that loads to the same configuration, each value annotated with its origin. For a
/// file in folder `dir`: paths are written relative to it.
[[nodiscard]] std::string dump_fleet(const FleetConfig& config, const std::string& dir);

/// Hash of every effective value; paths are hashed as given.
[[nodiscard]] std::uint64_t hash_fleet(const FleetConfig& config);

enum class SettingsShown {
  kPublic,  ///< by symptom: docs/reference/settings.md
  kAll,     ///< the unstable ones too, by group
};

/// Settings with default, allowed values, and meaning, as a page.
[[nodiscard]] std::string settings_manual(SettingsShown shown);

}  // namespace rali::config
