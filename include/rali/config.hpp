#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rali/error.hpp"
#include "rali/vehicle.hpp"

namespace rali {

/// Keys of docs/reference/settings.md with their values as they are written in YAML:
/// {"output.map_voxel_m", "0.1"},
/// {"vehicles.v1.lidar.topic", "/points"}.
using Settings = std::map<std::string, std::string>;

/// Overrides of the values of a file, or of the defaults.
struct LoadOptions {
  std::string preset;  ///< robust, paper; empty: the file's preset, else robust
  Settings settings;
};

/// Recordings and calibration of a fleet: a fleet.yaml with all defaults filled in. Cheap to copy.
class FleetConfig {
 public:
  struct Impl;
  explicit FleetConfig(std::shared_ptr<const Impl> impl);  ///< internal: used by the library only

  /// Names of the vehicles in their order.
  [[nodiscard]] std::vector<std::string> vehicles() const;

  /// Text of a fleet.yaml that loads to the same configuration; paths as given.
  [[nodiscard]] std::string yaml() const;

  /// Internal: used by the library only.
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Reads a fleet.yaml, or the settings.yaml of a run. Throws SettingsError with file and line,
/// InputError (the file cannot be read).
[[nodiscard]] FleetConfig load_fleet(const std::string& path, const LoadOptions& options = {});

/// Bare recordings (.bag .mcap .db3, scan folders), one vehicle each, named after the files; or one
/// fleet.yaml. Throws as load_fleet.
[[nodiscard]] FleetConfig load_inputs(const std::vector<std::string>& inputs,
                                      const LoadOptions& options = {});

/// `options` with a preset and the settings of one vehicle (odometry.*, ranging.*, vehicle.*)
/// applied over the defaults. Throws SettingsError.
[[nodiscard]] VehicleOptions with_settings(VehicleOptions options, const LoadOptions& settings);

}  // namespace rali
