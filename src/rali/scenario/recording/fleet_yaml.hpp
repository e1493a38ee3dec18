#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/scenario/recording/write_recording.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

/// fleet.yaml of a simulated recording: the files, and the calibration and start poses with the
/// errors of a user's measurement. config::load_fleet() reads it.
[[nodiscard]] std::string fleet_yaml(const sim::FleetSimulation& sim,
                                     const std::vector<std::string>& names,
                                     const RecordingOptions& options);

/// Network settings of a simulated fleet that is mapped live, all vehicles on one machine.
struct LiveNetwork {
  int ros_domain = 0;
  int fleet_domain = 77;
  std::string key_file = "fleet.key";  ///< in the folder of fleet.yaml
};

/// fleet.yaml of a fleet that `rali run` maps while the simulation publishes: topics instead of
/// files. Vehicle n has the address 127.0.0.n.
[[nodiscard]] std::string live_fleet_yaml(const sim::FleetSimulation& sim,
                                          const std::vector<std::string>& names,
                                          const RecordingOptions& options,
                                          const LiveNetwork& network);

/// A topic of one vehicle: "/v1/imu/data" for "v1" and "/imu/data".
[[nodiscard]] std::string live_topic(const std::string& vehicle, std::string_view topic);

/// Range topic of each vehicle: a relative name, as in ROS, in the vehicle's namespace.
inline constexpr std::string_view kLiveRangeTopic = "uwb";

}  // namespace rali::scenario
