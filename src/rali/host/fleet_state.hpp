#pragma once

#include <map>
#include <optional>
#include <vector>

#include "rali/host/fleet_side.hpp"
#include "rali/net/fleet_link.hpp"

namespace rali::host {

/// Facts that only the host knows.
struct HostFacts {
  std::vector<net::LinkCounts> links;
  std::map<VehicleId, double> rates_Bps;  ///< recent receive rates
  bool has_link = false;                  ///< the fleet has more than one vehicle
  std::optional<StateDisk> disk;
  std::size_t unsynced_facts = 0;
  double step_p50_s = 0.0, step_p99_s = 0.0, step_max_s = 0.0;
  std::size_t queue = 0, queue_max = 0;
  std::uint64_t queue_refused = 0;  ///< values that did not fit into a queue between threads
  std::uint32_t epoch = 0;
};

/// The lines of /diagnostics: one per sensor, then odometry, map, role, links, disk and program.
[[nodiscard]] std::vector<DiagnosticLine> diagnose(const FleetSide& side, const HostFacts& host,
                                                   HostTime now);

/// The fleet as currently known to this vehicle.
[[nodiscard]] LiveState live_state(const FleetSide& side, const HostFacts& host, HostTime now);

}  // namespace rali::host
