#pragma once

#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::sim::internal {

/// A hall of 20 x 14 x 3 m with pillars and, for up to three vehicles, two short rounds: the first
/// vehicle is stationary while the second drives past it, then the reverse. For tests.
inline World room(int vehicles) {
  World world;
  world.mesh.add_box({5.0, 0.0, 0.0}, {20.0, 14.0, 3.0}, 0.0, 0.6);
  world.mesh.add_cylinder({3.0, 4.0, 0.0}, 0.2, 3.0, 12, 0.5);
  world.mesh.add_cylinder({9.0, -4.0, 0.0}, 0.2, 3.0, 12, 0.5);
  world.route = {{0, 0, 0}, {10, 0, 0}};
  const std::vector<VehicleStart> starts = {
      {{3.0, 0.0, 0.0}, 0.0}, {{0.0, 1.5, 0.0}, 0.0}, {{-2.0, -3.0, 0.0}, 0.0}};
  world.starts.assign(starts.begin(), starts.begin() + vehicles);
  world.rounds = {{0, {{}, {{0.0, 1.5, 0.0}, {8.0, 1.5, 0.0}}}},
                  {1, {{{3.0, 0.0, 0.0}, {10.0, -1.0, 0.0}, {10.0, 3.0, 0.0}}, {}}}};
  return world;
}

/// All sensors without errors; small scans of 16 rings.
inline FleetOptions quiet_fleet(int vehicles) {
  FleetOptions o;
  o.vehicles = vehicles;
  o.vehicle.imu = ImuOptions::ideal();
  o.vehicle.ranging.noise_m = 0.0;
  o.vehicle.ranging.resolution_m = 0.001;
  o.vehicle.ranging.max_range_m = 60.0;
  o.vehicle.ranging.dropouts = false;
  o.vehicle.ranging.mixed_fraction = 0.0;
  o.vehicle.motion.standstill_s = 0.5;
  o.pause_s = 1.0;
  o.uwb = UwbOptions::ideal();
  o.radio = RadioOptions::ideal();
  return o;
}

}  // namespace rali::sim::internal
