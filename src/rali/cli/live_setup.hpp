#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "rali/config/fleet_config.hpp"
#include "rali/host/live_host.hpp"
#include "rali/net/fleet_link.hpp"
#include "rali/net/ros_bus.hpp"

namespace rali::cli {

/// Configuration of `rali run` for one vehicle, from a fleet.yaml.
struct LiveSetup {
  host::LiveHostSetup host;
  std::size_t index = 0;  ///< of the vehicle in the fleet
};

/// Number of a vehicle by its name. Errors: kUsage, with the known names.
[[nodiscard]] Result<std::size_t> vehicle_index(const config::FleetConfig& fleet,
                                                const std::string& name);

/// Errors: kUsage (settings that this version does not support), kInput (referenced files).
[[nodiscard]] Result<LiveSetup> make_live_setup(const config::FleetConfig& fleet,
                                                std::size_t index);

/// All vehicles of the fleet, by number.
[[nodiscard]] std::vector<VehicleId> vehicle_ids(const config::FleetConfig& fleet);

/// Restores the state stored on the vehicle's disk.
void restore(LiveSetup& setup, drive::StateDir& state);

/// The ROS domain of the vehicle's own network. Errors: those of net::open_dds_ros_bus.
[[nodiscard]] Result<std::unique_ptr<net::RosBus>> open_ros_bus(const config::FleetConfig& fleet,
                                                                std::size_t index);

/// The link to the other vehicles; null for a single vehicle. Messages of epochs older than those
/// of the facts on the disk are rejected as replayed.
/// @param start  state stored on the vehicle's disk
/// @param seen  messages accepted by earlier starts (StateDir::seen)
/// Errors: kUsage (no key, no address), those of net::open_dds_fleet_link
[[nodiscard]] Result<std::unique_ptr<net::FleetLink>> open_fleet_link(
    const config::FleetConfig& fleet, std::size_t index, const fleet::NodeStart& start,
    std::span<const std::byte> seen);

/// The first word of a file; "" for no file. Errors: kInput.
[[nodiscard]] Result<std::string> read_token(const std::string& path);

}  // namespace rali::cli
