#include "rali/sim/fleet/fleet_motion.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kClear_m = 0.85;  // between the centres of two vehicles that pass each other
constexpr double kLook_m = 0.6;    // look-ahead beyond the stopping distance
constexpr double kStep_m = 0.15;
constexpr double kStorey_m = 1.5;
constexpr double kFar_m = 12.0;  // exceeds the stopping distances of two vehicles

/// Horizontal distance; vehicles on different storeys are far apart.
double apart_m(const Vec3& a, const Vec3& b) {
  if (std::abs(a.z() - b.z()) > kStorey_m) return 1e9;
  return (a - b).head<2>().norm();
}

double reach_m(const Rover& rover) { return rover.stopping_m() + kLook_m; }

/// Smallest distance of a point from the path of `other` over the next `ahead_m`.
double apart_from_path_m(const Vec3& p, const Rover& other, double ahead_m) {
  double minimum = apart_m(p, other.ground());
  for (double r = kStep_m; r < ahead_m + kStep_m; r += kStep_m) {
    minimum = std::min(minimum, apart_m(p, other.ground_ahead(r)));
  }
  return minimum;
}

/// True if the path ahead comes too close to the position of `other`, or to its path while braking.
/// Moving away from it is allowed.
bool runs_into(const Rover& rover, const Rover& other) {
  const double theirs_m = other.standing() ? -kStep_m : other.stopping_m();
  double last = apart_from_path_m(rover.ground(), other, theirs_m);
  for (double s = kStep_m; s < reach_m(rover) + kStep_m; s += kStep_m) {
    const double d = apart_from_path_m(rover.ground_ahead(s), other, theirs_m);
    if (d < kClear_m && d < last) return true;
    last = d;
  }
  return false;
}

/// True if the paths of the next metres come too close to each other.
bool paths_cross(const Rover& rover, const Rover& other) {
  const double theirs_m = reach_m(other) + 1.0;
  if (apart_from_path_m(rover.ground(), other, theirs_m) < kClear_m) return false;  // blocks it
  for (double s = kStep_m; s < reach_m(rover) + kStep_m; s += kStep_m) {
    if (apart_from_path_m(rover.ground_ahead(s), other, theirs_m) < kClear_m) return true;
  }
  return false;
}

}  // namespace

std::uint64_t vehicle_seed(std::uint64_t seed, int vehicle) {
  if (vehicle == 0) return seed;
  return Rng(seed, "vehicle " + std::to_string(vehicle)).next();
}

FleetMotion::FleetMotion(const World& world, const MotionOptions& options, int vehicles,
                         std::uint64_t seed)
    : waited_s_(static_cast<std::size_t>(vehicles), 0.0) {
  RALI_ASSERT(static_cast<int>(world.starts.size()) >= vehicles);
  for (int v = 0; v < vehicles; ++v) {
    rovers_.push_back(std::make_unique<Rover>(options, world.starts[static_cast<std::size_t>(v)],
                                              vehicle_seed(seed, v)));
  }
}

bool FleetMotion::must_wait(const Rover& rover, std::size_t index) const {
  for (std::size_t k = 0; k < rovers_.size(); ++k) {
    const Rover& other = *rovers_[k];
    if (k == index || apart_m(rover.ground(), other.ground()) > kFar_m) continue;
    if (runs_into(rover, other)) return true;
    if (k < index && !other.standing() && paths_cross(rover, other)) return true;
  }
  return false;
}

void FleetMotion::step() {
  // First all decisions, then all motion: the order of the vehicles must not matter.
  for (std::size_t i = 0; i < rovers_.size(); ++i) {
    const bool waiting = !rovers_[i]->idle() && must_wait(*rovers_[i], i);
    rovers_[i]->hold(waiting);
    waited_s_[i] = waiting ? waited_s_[i] + Rover::kTick_s : 0.0;
  }
  for (const std::unique_ptr<Rover>& rover : rovers_) rover->step();
}

bool FleetMotion::all_idle() const {
  return std::all_of(rovers_.begin(), rovers_.end(), [](const auto& r) { return r->idle(); });
}

namespace {

void stand(FleetMotion& fleet, double span_s) {
  const double end_s = fleet.time_s() + span_s - 0.5 * Rover::kTick_s;
  while (fleet.time_s() < end_s) fleet.step();
}

/// Steps until all have arrived; returns the blocked vehicle, or -1.
int drive_until_idle(FleetMotion& fleet) {
  constexpr double kPatience_s = 60.0;
  while (!fleet.all_idle()) {
    fleet.step();
    for (int v = 0; v < fleet.vehicles(); ++v) {
      if (fleet.waited_s(v) > kPatience_s) return v;
    }
  }
  return -1;
}

}  // namespace

Result<std::vector<RoundTimes>> drive_rounds(FleetMotion& fleet, const World& world,
                                             double standstill_s, double pause_s) {
  std::vector<RoundTimes> times;
  stand(fleet, standstill_s);
  for (std::size_t k = 0; k < world.rounds.size(); ++k) {
    const RoundPlan& round = world.rounds[k];
    if (k > 0) stand(fleet, round.pause_s.value_or(pause_s));
    RoundTimes t{round.anchor, fleet.time_s(), 0.0};
    for (int v = 0; v < fleet.vehicles(); ++v) {
      const auto i = static_cast<std::size_t>(v);
      if (v == round.anchor || i >= round.routes.size() || round.routes[i].empty()) continue;
      fleet.rover(v).follow(round.routes[i], world.rounding_m);
    }
    const int stuck = drive_until_idle(fleet);
    if (stuck >= 0) {
      return fail(
          ErrorCode::kUsage, fmt::format("rounds[{}]", k),
          fmt::format("vehicle {} cannot get past another one that stands in its way", stuck + 1),
          "Keep 1 m between the ways of this round and the places where others stand.");
    }
    t.end_s = fleet.time_s();
    times.push_back(t);
  }
  stand(fleet, 1.0);
  return times;
}

}  // namespace rali::sim
