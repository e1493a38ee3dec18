#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/config/fleet_config.hpp"
#include "rali/drive/map_run.hpp"

namespace rali::jobs {

/// The options of `rali map` besides the fleet.
struct MapOptions {
  std::string out_dir = "out";
  std::vector<std::string> formats = {"pcd", "ply"};
  bool mcap = true, keyframes = true;
  bool strict = false, overwrite = false;
  bool imu_rate = false;
  int threads = 0;
  std::string command_line;
  std::shared_ptr<const drive::FleetFacts> facts;  ///< of load_inputs; null: recordings
};

/// The job for the room drive. settings.yaml of the job lists the values determined from the data
/// with their origin.
/// Errors (kUsage): settings that this version reads but does not support.
[[nodiscard]] Result<drive::MapJob> make_map_job(const config::FleetConfig& fleet,
                                                 const MapOptions& options);

/// The settings of one vehicle, with calibration and noise from the fleet settings.
/// @param index of the vehicle in the fleet
[[nodiscard]] vehicle::VehicleSettings vehicle_settings(const config::FleetConfig& fleet,
                                                        std::size_t index);

/// Keys that were given but have no effect in this version, or on a single vehicle, for one
/// warning; empty if none.
[[nodiscard]] std::vector<std::string> idle_keys(const config::FleetConfig& fleet);

/// The fleet with all values determined from the data, and their origin.
[[nodiscard]] config::FleetConfig with_findings(const config::FleetConfig& fleet,
                                                const std::vector<drive::InputReport>& reports);

}  // namespace rali::jobs
