#pragma once

#include <cstdint>
#include <string>

#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::tunnel {

/// Position along the path of the stationary vehicle to which ranges are measured.
enum class AnchorPlace { kStart, kMiddle };

/// Index of the vehicles: the first is stationary, the second drives and is tested.
inline constexpr int kAnchor = 0;
inline constexpr int kDriver = 1;

/// All options that affect the LiDAR data of the driving vehicle.
struct Place {
  sim::Scene scene = sim::Scene::kTunnel;
  std::uint64_t seed = 1;
  AnchorPlace anchor = AnchorPlace::kMiddle;
  sim::Lidar lidar = sim::Lidar::kRs16;
  double duration_s = 0.0;  ///< 0: the whole path

  [[nodiscard]] bool operator==(const Place&) const = default;
};

[[nodiscard]] std::string name_of(const Place& place);

/// World and options of one stationary vehicle beside the path and one that drives along it.
struct Setup {
  sim::World world;
  sim::FleetOptions options;
  double anchor_arc_m = 0.0;   ///< along the path
  double anchor_side_m = 0.0;  ///< to its left
};

/// Places the anchor where it touches nothing and the driver can pass, as close as possible to the
/// requested position. Errors (kNoAnswer): there is no such position.
[[nodiscard]] Result<Setup> make_setup(const Place& place);

/// Radios of the acceptance test: 7 cm in all (6 white, 3.5 slowly varying), pair bias sd 6 cm and
/// never above 10 cm, 1 % gross errors. The first path is missed for `burst_fraction` of the time
/// although the line of sight is free.
[[nodiscard]] sim::UwbOptions radios(std::uint64_t seed, double burst_fraction);

}  // namespace rali::tunnel
