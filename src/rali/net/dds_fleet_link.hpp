#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/net/fleet_key.hpp"
#include "rali/net/fleet_link.hpp"
#include "rali/net/seen_counters.hpp"

namespace rali::net {

/// Another vehicle of the fleet.
struct FleetPeer {
  VehicleId id;
  std::string address;  ///< IPv4
  /// Messages of a lower epoch are rejected as replays. From this vehicle's log.
  std::uint32_t epoch_min = 0;
};

struct FleetLinkOptions {
  VehicleId self;
  /// Of this start of the program; must never be used twice with the same key: increment and sync
  /// it before the link is opened.
  std::uint32_t epoch = 0;
  /// IPv4 of this vehicle in the fleet's network. Vehicles on one machine are 127.0.0.1 to
  /// 127.0.0.100: they share the interface 127.0.0.1 and differ by their UDP ports.
  std::string address;
  std::vector<FleetPeer> peers;   ///< all other vehicles of the fleet
  std::vector<SeenCounter> seen;  ///< by earlier starts: not accepted again. From disk
  int domain = 77;                ///< 0 to 232; must differ from ROS_DOMAIN_ID
  FleetKey key;
  /// A fact of 1 MiB with its framing.
  std::size_t message_bytes_max = (std::size_t{1} << 20) + 1024;
  std::size_t queue_bytes_max = std::size_t{8} << 20;  ///< arrived and not taken, per peer
  std::string cyclone_config;  ///< XML of Cyclone DDS or file:// names, applied over ours
};

/// Cyclone DDS, unicast, each message sealed by the fleet's key.
/// Errors: kUsage (an option out of its range), kMachine (no such address, port taken, no memory).
[[nodiscard]] Result<std::unique_ptr<FleetLink>> open_dds_fleet_link(
    const FleetLinkOptions& options);

}  // namespace rali::net
