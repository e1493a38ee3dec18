#include "rali/sim/fleet/closed_loop.hpp"

#include <cmath>
#include <utility>

#include <fmt/core.h>

#include "rali/sim/fleet/goal_driver.hpp"
#include "rali/sim/internal/range_check.hpp"

namespace rali::sim {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// Transforms from the software's map to the world by position and heading alone: a tilt error of
/// the estimate does not lift goals off the ground.
std::vector<Vec3> places_in_world(const DriveCommand& command, const SE3& T_world_body) {
  const double turn = geometry::rpy_from_rotation(T_world_body.R).z() -
                      geometry::rpy_from_rotation(command.T_map_body.R).z();
  const SE3 T_turn{geometry::rotation_from_rpy(0.0, 0.0, turn), Vec3::Zero()};
  std::vector<Vec3> out;
  for (const Vec3& p : command.places_map_m) {
    out.push_back(T_world_body.p + T_turn.R * (p - command.T_map_body.p));
  }
  return out;
}

bool finite(const DriveCommand& command) {
  bool good = command.T_map_body.p.allFinite() && command.T_map_body.R.allFinite();
  for (const Vec3& p : command.places_map_m) good = good && p.allFinite();
  return good;
}

/// Delivers all available messages to the software.
void deliver(FleetSimulation& simulation, FleetSoftware& software,
             const ClosedLoopOptions& options) {
  while (const std::optional<FleetMessage> message = simulation.next()) {
    if (options.tap) options.tap(*message);
    software.on_message(*message);
  }
}

void advance(FleetMotion& motion, std::vector<GoalDriver>& drivers, double span_s) {
  const double end_s = motion.time_s() + span_s - 0.5 * Rover::kTick_s;
  while (motion.time_s() < end_s) {
    for (GoalDriver& driver : drivers) driver.update();
    motion.step();
  }
}

Status obey(const std::vector<DriveCommand>& commands, const FleetSimulation& simulation,
            std::vector<GoalDriver>& drivers) {
  for (const DriveCommand& c : commands) {
    if (c.vehicle < 0 || c.vehicle >= static_cast<int>(drivers.size())) {
      return fail(ErrorCode::kUsage, "vehicle",
                  fmt::format("a command is for vehicle {} of {}", c.vehicle, drivers.size()),
                  "Count vehicles from 0.");
    }
    if (!finite(c)) {
      return fail(ErrorCode::kUsage, "places_map_m", "a command has a place that is no number");
    }
    GoalDriver& driver = drivers[static_cast<std::size_t>(c.vehicle)];
    if (c.kind == DriveCommand::Kind::kStop || c.places_map_m.empty()) {
      driver.stop();
    } else {
      driver.go(places_in_world(c, simulation.truth(c.vehicle, c.t).state.T_world_body));
    }
  }
  return {};
}

Status check(const FleetSimulation& simulation, ClosedLoopOptions options) {
  if (simulation.scripted()) {
    return fail(ErrorCode::kUsage, "scripted", "the vehicles of this simulation follow a script",
                "Make it with scripted = false.");
  }
  RangeCheck ranges;
  options.visit(ranges);
  if (!ranges.bad.empty()) {
    return fail(ErrorCode::kUsage, ranges.bad, "this option is outside its range",
                "`rali simulate --help` lists the ranges.");
  }
  return {};
}

}  // namespace

Result<Mission> run_closed_loop(FleetSimulation& simulation, FleetSoftware& software,
                                const ClosedLoopOptions& options) {
  if (const Status checked = check(simulation, options); !checked) {
    return tl::make_unexpected(checked.error());
  }
  const Result<PathPlanner> planner = PathPlanner::make(simulation.mesh());
  if (!planner) return tl::make_unexpected(planner.error());
  FleetMotion& motion = simulation.motion();
  std::vector<GoalDriver> drivers;
  for (int v = 0; v < simulation.vehicles(); ++v) {
    drivers.emplace_back(v, motion, *planner, options);
  }
  std::vector<DriveReport> reports(drivers.size());
  while (!software.finished() && motion.time_s() < options.time_limit_s) {
    advance(motion, drivers, options.decide_every_s);
    deliver(simulation, software, options);
    for (std::size_t v = 0; v < drivers.size(); ++v) reports[v] = drivers[v].report();
    const Status obeyed = obey(software.decide(simulation.t_end(), reports), simulation, drivers);
    if (!obeyed) return tl::make_unexpected(obeyed.error());
  }
  Mission mission;
  mission.finished = software.finished();
  for (GoalDriver& driver : drivers) driver.stop();
  advance(motion, drivers, options.end_s);
  deliver(simulation, software, options);
  mission.duration_s = motion.time_s();
  for (int v = 0; v < simulation.vehicles(); ++v) mission.path_m.push_back(simulation.path_m(v));
  return mission;
}

}  // namespace rali::sim
