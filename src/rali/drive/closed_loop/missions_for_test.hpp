#pragma once

// Worlds and settings of missions whose vehicles have exact poses.

#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "rali/drive/closed_loop/exact_fleet_for_test.hpp"

namespace rali::drive {

using Simulation = std::unique_ptr<sim::FleetSimulation>;

inline Simulation driven(sim::World world, int vehicles) {
  sim::FleetOptions options;
  options.vehicles = vehicles;
  options.scripted = false;
  options.vehicle.with_lidar = false;
  options.vehicle.with_imu = false;
  auto sim = sim::make_fleet_simulation(std::move(world), options);
  EXPECT_TRUE(sim.has_value());
  return std::move(*sim);
}

/// Three rooms in a row, each of which hides the next: walls with doors on alternating sides.
inline Simulation three_rooms() {
  sim::World world;
  world.mesh.add_box({9.0, 0.0, 0.0}, {26.0, 12.0, 3.0}, 0.0, 0.6);
  world.mesh.add_box({6.0, -1.5, 0.0}, {0.2, 9.0, 3.0}, 0.0, 0.6);
  world.mesh.add_box({14.0, 1.5, 0.0}, {0.2, 9.0, 3.0}, 0.0, 0.6);
  world.route = {{0.0, 0.0, 0.0}, {20.0, 0.0, 0.0}};
  world.starts = {{{0.0, 0.0, 0.0}, 0.0}, {{-2.0, 2.0, 0.0}, 0.0}, {{-2.0, -2.0, 0.0}, 0.0}};
  return driven(std::move(world), 3);
}

/// A corridor around a corner. The first vehicle is ahead of the second, which cannot pass it.
inline Simulation narrow_corridor(double width_m = 1.4, int vehicles = 2) {
  const double half = 0.5 * width_m;
  sim::World world;
  const auto box = [&world](double x_m, double low_m) {
    world.mesh.add_box({0.5 * (x_m - 4.0), 0.5 * (low_m + 12.0), 0.0},
                       {x_m + 4.0, 12.0 - low_m, 2.5}, 0.0, 0.6);
  };
  box(9.3 + half, -half);
  box(9.3 - half, half);
  world.route = {{0.0, 0.0, 0.0}, {9.3, 0.0, 0.0}, {9.3, 11.0, 0.0}};
  world.starts = {{{3.0, 0.0, 0.0}, 0.0}, {{0.0, 0.0, 0.0}, 0.0}, {{-2.0, 0.0, 0.0}, 0.0}};
  world.starts.resize(static_cast<std::size_t>(vehicles));
  return driven(std::move(world), vehicles);
}

inline fleet::NodeSettings without_loops() {
  fleet::NodeSettings settings;
  settings.fleet.loops.use = false;
  return settings;
}

inline sim::ClosedLoopOptions limited(double time_limit_s) {
  sim::ClosedLoopOptions options;
  options.time_limit_s = time_limit_s;
  return options;
}

}  // namespace rali::drive
