#include "place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "rali/base/rng.hpp"
#include "rali/sim/clearance.hpp"

namespace rali::tunnel {

using geometry::Vec3;

namespace {

constexpr double kStartArc_m = 1.5;
constexpr double kNarrow_m = 1.05;        // anchor closer to the path: the driver swings less
constexpr double kNarrowWander_m = 0.03;  // lateral swing in that case
constexpr double kPass_m = 0.86;          // vehicles closer than this do not pass each other

double length_of(const std::vector<Vec3>& path) {
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

/// The point at `arc_m` along the path, and the direction there.
std::pair<Vec3, Vec3> at_arc(const std::vector<Vec3>& path, double arc_m) {
  double left = arc_m;
  for (std::size_t i = 1;; ++i) {
    const Vec3 step = path[i] - path[i - 1];
    const double length = step.norm();
    if (left <= length || i + 1 == path.size()) {
      const Vec3 d = step / std::max(1e-9, length);
      return {path[i - 1] + std::clamp(left, 0.0, length) * d, d};
    }
    left -= length;
  }
}

double distance_to_path(const Vec3& p, const std::vector<Vec3>& path) {
  double minimum = 1e9;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vec3 step = path[i] - path[i - 1];
    const double s = std::clamp((p - path[i - 1]).dot(step) / step.squaredNorm(), 0.0, 1.0);
    minimum = std::min(minimum, (path[i - 1] + s * step - p).head<2>().norm());
  }
  return minimum;
}

double yaw_of(const Vec3& d) { return std::atan2(d.y(), d.x()); }

/// One attempt with the anchor `side_m` to the left of the path at `arc_m`; empty if it does not
/// fit.
std::optional<Setup> try_setup(const sim::World& world, const sim::Clearance& clearance,
                               sim::FleetOptions options, double arc_m, double side_m) {
  const auto [on_path, d] = at_arc(world.route, arc_m);
  const Vec3 stand = on_path + side_m * Vec3(-d.y(), d.x(), 0.0).normalized();
  if (distance_to_path(stand, world.route) < kPass_m) return std::nullopt;
  if (!clearance.free_at(stand, {})) return std::nullopt;
  if (std::abs(side_m) < kNarrow_m) options.vehicle.motion.wander_m = kNarrowWander_m;
  Setup setup{world, options, arc_m, side_m};
  const Vec3 d0 = world.route[1] - world.route[0];
  setup.world.starts = {{stand, yaw_of(d)}, {world.route[0], yaw_of(d0)}};
  sim::RoundPlan round;
  round.anchor = kAnchor;
  round.routes = {{}, world.route};
  setup.world.rounds = {round};
  // Only a simulation shows whether the two can pass each other.
  sim::FleetOptions without_lidar = options;
  without_lidar.vehicle.with_lidar = false;
  if (!sim::make_fleet_simulation(setup.world, without_lidar)) return std::nullopt;
  return setup;
}

}  // namespace

std::string name_of(const Place& place) {
  return fmt::format("{} {} seed {}", sim::kSceneNames[static_cast<std::size_t>(place.scene)],
                     place.anchor == AnchorPlace::kStart ? "start" : "middle", place.seed);
}

Result<Setup> make_setup(const Place& place) {
  sim::FleetOptions options;
  options.vehicles = 2;
  options.radio_link = false;
  options.vehicle.scene = place.scene;
  options.vehicle.seed = place.seed;
  options.vehicle.lidar = place.lidar;
  options.vehicle.duration_s = place.duration_s;
  const sim::World world = sim::make_world(place.scene, place.seed);
  const sim::Clearance clearance(world.mesh);
  const double first_arc =
      place.anchor == AnchorPlace::kStart ? kStartArc_m : 0.5 * length_of(world.route);
  const double left = place.seed % 2 == 1 ? 1.0 : -1.0;
  constexpr std::array kSides_m{1.2, 1.1, 1.0, 0.9};
  constexpr double kStep_m = 1.5;
  for (int step = 0; step < 24; ++step) {
    // 0, +1, -1, +2, ...: at the start only ahead.
    const bool ahead = place.anchor == AnchorPlace::kStart || step % 2 == 1;
    const int steps = place.anchor == AnchorPlace::kStart ? step : (step + 1) / 2;
    const double arc_m = first_arc + (ahead ? kStep_m : -kStep_m) * steps;
    for (const double side_m : kSides_m) {
      for (const double sign : {left, -left}) {
        auto setup = try_setup(world, clearance, options, arc_m, sign * side_m);
        if (setup) return std::move(*setup);
      }
    }
  }
  return fail(ErrorCode::kNoAnswer, name_of(place), "nowhere can the anchor stand aside");
}

sim::UwbOptions radios(std::uint64_t seed, double burst_fraction) {
  sim::UwbOptions o;
  o.sigma_m = 0.06;  // with the part that wanders, 0.035 m, 7 cm in all
  o.sigma_per_m = 0.0002;
  constexpr double kBiasSigma_m = 0.06;
  constexpr double kBiasMax_m = 0.10;
  Rng rng(seed, "pair bias");
  o.pair_bias_m = std::clamp(kBiasSigma_m * rng.normal(), -kBiasMax_m, kBiasMax_m);
  o.pair_bias_sd_m = 0.0;
  o.outlier_fraction = 0.01;
  o.clear_burst_fraction = burst_fraction;
  o.max_range_m = 300.0;
  o.sensitivity_dbm = -112.0;  // received along the whole tunnel
  return o;
}

}  // namespace rali::tunnel
