#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "rali/sim/fleet/fleet_simulation.hpp"
#include "rali/sim/fleet/path_planner.hpp"

namespace rali::sim {

/// Command from the fleet software to a vehicle.
struct DriveCommand {
  enum class Kind { kGo, kStop };

  int vehicle = 0;
  Kind kind = Kind::kGo;
  /// Waypoints to visit in order, the last one is the goal; in the software's map frame, on the
  /// ground or up to a metre above it. One is enough: the planner finds a path around obstacles.
  std::vector<geometry::Vec3> places_map_m;
  /// Estimated pose of the vehicle's body at `t`. Vehicles drive by their own estimate: its error
  /// becomes an error of the goal, as in reality.
  geometry::SE3 T_map_body;
  Time t;
};

enum class DriveStatus {
  kStanding,     ///< has no goal
  kDriving,      ///< on its path, or waiting for another vehicle to pass
  kArrived,      ///< stopped at its goal
  kUnreachable,  ///< gave up: no path leads there
  kBlocked       ///< gave up: stationary vehicles block every path for good
};

/// Drive status of a vehicle, reported to the fleet software.
struct DriveReport {
  DriveStatus status = DriveStatus::kStanding;
  std::uint64_t goals = 0;  ///< number of go commands accepted so far
};

/// Interface between the simulator and a fleet's software. Called from one thread in virtual time.
class FleetSoftware {
 public:
  virtual ~FleetSoftware() = default;

  /// Receives all sensor messages of all vehicles in order of arrival.
  virtual void on_message(const FleetMessage& message) = 0;

  /// Called every decide_every_s. A new goal replaces the old one.
  /// @param vehicles  by vehicle
  [[nodiscard]] virtual std::vector<DriveCommand> decide(Time now,
                                                         std::span<const DriveReport> vehicles) = 0;

  /// True when the mission is over; the simulation then ends.
  [[nodiscard]] virtual bool finished() const = 0;
};

struct ClosedLoopOptions {
  double decide_every_s = 0.1;
  double blocked_s = 4.0;        ///< after this wait for another vehicle it tries another path
  int blocked_tries = 8;         ///< then it gives up
  double time_limit_s = 3600.0;  ///< of the mission
  double end_s = 2.0;            ///< standstill after the mission
  /// Receives every message before the software does: for recording.
  std::function<void(const FleetMessage&)> tap;

  template <class V>
  void visit(V& v) {
    v("decide_every_s", decide_every_s, 0.02, 10.0, "how often the fleet software decides");
    v("blocked_s", blocked_s, 0.5, 600.0, "waiting time before a vehicle tries another way");
    v("blocked_tries", blocked_tries, 0.0, 1000.0, "ways tried before it gives up");
    v("time_limit_s", time_limit_s, 1.0, 36000.0, "longest mission");
    v("end_s", end_s, 0.0, 600.0, "standing time after the mission");
  }
};

/// Outcome of a mission.
struct Mission {
  bool finished = false;  ///< false: stopped by the time limit
  double duration_s = 0.0;
  std::vector<double> path_m;  ///< by vehicle
};

/// Lets `software` drive the vehicles of a simulation that is not scripted.
/// Errors (kUsage): the simulation is scripted, an option is out of range, or a command has an
/// unknown vehicle; and those of NavigationGrid::build().
[[nodiscard]] Result<Mission> run_closed_loop(FleetSimulation& simulation, FleetSoftware& software,
                                              const ClosedLoopOptions& options = {});

}  // namespace rali::sim
