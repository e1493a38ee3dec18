#pragma once

#include <cstdint>
#include <string>

#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::tunnel {

/// Where along the way the vehicle stands to which ranges are measured.
enum class AnchorPlace { kStart, kMiddle };

/// The vehicles by their number: the first stands, the second drives and is what is tested.
inline constexpr int kAnchor = 0;
inline constexpr int kDriver = 1;

/// What decides what the LiDAR of the driving vehicle sees.
struct Place {
  sim::Scene scene = sim::Scene::kTunnel;
  std::uint64_t seed = 1;
  AnchorPlace anchor = AnchorPlace::kMiddle;
  sim::Lidar lidar = sim::Lidar::kRs16;
  double duration_s = 0.0;  ///< 0: the whole way

  [[nodiscard]] bool operator==(const Place&) const = default;
};

[[nodiscard]] std::string name_of(const Place& place);

/// World and options of one vehicle that stands beside the way and one that drives along it.
struct Setup {
  sim::World world;
  sim::FleetOptions options;
  double anchor_arc_m = 0.0;   ///< along the way
  double anchor_side_m = 0.0;  ///< to its left
};

/// Stands the anchor where nothing touches it and the driver can pass, as near as possible to what
/// is asked. Errors (kNoAnswer): there is no such place.
[[nodiscard]] Result<Setup> make_setup(const Place& place);

/// Radios of the acceptance test: 7 cm in all (6 white, 3.5 wandering slowly), pair bias
/// sd 6 cm and never above 10 cm, 1 % gross errors; `burst_share` of the time the first path is
/// missed though nothing is in the way.
[[nodiscard]] sim::UwbOptions radios(std::uint64_t seed, double burst_share);

}  // namespace rali::tunnel
