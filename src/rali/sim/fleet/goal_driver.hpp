#pragma once

#include <vector>

#include "rali/sim/fleet/closed_loop.hpp"

namespace rali::sim {

/// Drives one vehicle to its goals: stops, plans, follows, and tries other paths when another
/// vehicle blocks it.
class GoalDriver {
 public:
  GoalDriver(int vehicle, FleetMotion& fleet, const PathPlanner& planner,
             const ClosedLoopOptions& options)
      : vehicle_(vehicle), fleet_(&fleet), planner_(&planner), options_(&options) {}

  /// @param places_world_m  waypoints to visit in order, near the ground
  void go(std::vector<geometry::Vec3> places_world_m);
  void stop();

  /// To be called between ticks.
  void update();

  [[nodiscard]] const DriveReport& report() const { return report_; }

 private:
  [[nodiscard]] Rover& rover() const { return fleet_->rover(vehicle_); }

  void set_out();
  [[nodiscard]] std::vector<geometry::Vec3> others_in_the_way() const;
  [[nodiscard]] bool others_stand() const;

  int vehicle_;
  FleetMotion* fleet_;
  const PathPlanner* planner_;
  const ClosedLoopOptions* options_;
  std::vector<geometry::Vec3> places_;  ///< waypoints, world; empty: no goal
  bool on_path_ = false;                ///< follows a path to places_
  bool around_ = false;                 ///< the next path avoids the other vehicles
  int tries_ = 0;
  int shut_ = 0;               ///< times that vehicles without a goal blocked all paths
  double wait_until_s_ = 0.0;  ///< no new path before this time
  DriveReport report_;
};

}  // namespace rali::sim
