#include "rali/sim/fleet/goal_driver.hpp"

#include <utility>

namespace rali::sim {

using geometry::Vec3;

void GoalDriver::go(std::vector<Vec3> places_world_m) {
  places_ = std::move(places_world_m);
  on_path_ = around_ = false;
  tries_ = shut_ = 0;
  wait_until_s_ = 0.0;
  ++report_.goals;
  report_.status = DriveStatus::kDriving;
  rover().halt();
}

void GoalDriver::stop() {
  places_.clear();
  on_path_ = false;
  rover().halt();
  report_.status = DriveStatus::kStanding;
}

namespace {

constexpr double kFar_m = 15.0;  // vehicles farther away will have moved on
constexpr int kShut = 2;         // after one failure a vehicle may have just stopped there

}  // namespace

/// True if all nearby vehicles are stationary and without a path.
bool GoalDriver::others_stand() const {
  for (int v = 0; v < fleet_->vehicles(); ++v) {
    const Rover& other = fleet_->rover(v);
    if (v == vehicle_ || (other.ground() - rover().ground()).norm() >= kFar_m) continue;
    if (!other.standing() || !other.idle()) return false;
  }
  return true;
}

std::vector<Vec3> GoalDriver::others_in_the_way() const {
  std::vector<Vec3> out;
  for (int v = 0; v < fleet_->vehicles(); ++v) {
    const Vec3& p = fleet_->rover(v).ground();
    if (v != vehicle_ && (p - rover().ground()).norm() < kFar_m) out.push_back(p);
  }
  return out;
}

void GoalDriver::set_out() {
  std::vector<Vec3> others;
  if (around_) others = others_in_the_way();
  if (tries_ > options_->blocked_tries || shut_ >= kShut) {
    places_.clear();
    report_.status = DriveStatus::kBlocked;
    return;
  }
  const Result<PlannedPath> path = planner_->plan(rover().ground(), places_, others);
  if (path) {
    rover().follow(path->corners, path->rounding_m);
    on_path_ = true;
    return;
  }
  // A path blocked by another vehicle may become free; a wall stays.
  if (around_) {
    around_ = false;
    if (others_stand()) ++shut_;
    wait_until_s_ = fleet_->time_s() + options_->blocked_s;
    return;
  }
  places_.clear();
  report_.status = DriveStatus::kUnreachable;
}

void GoalDriver::update() {
  if (places_.empty()) return;
  if (on_path_) {
    if (rover().idle()) {
      places_.clear();
      on_path_ = false;
      report_.status = DriveStatus::kArrived;
    } else if (fleet_->waited_s(vehicle_) > options_->blocked_s * (1.0 + 0.3 * vehicle_)) {
      // Different waiting times: two vehicles facing each other would both try the same side.
      rover().halt();
      on_path_ = false;
      around_ = true;
      ++tries_;
    }
    return;
  }
  if (rover().idle() && rover().standing() && fleet_->time_s() >= wait_until_s_) set_out();
}

}  // namespace rali::sim
