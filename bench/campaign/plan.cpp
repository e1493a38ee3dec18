#include "plan.hpp"

#include <algorithm>
#include <cmath>

#include "rali/sim/rounds.hpp"
#include "rali/sim/route.hpp"

namespace rali::campaign {

using geometry::Vec3;
using sim::RoundPlan;
using sim::Route;
using sim::World;

namespace {

constexpr double kLaneMin_m = 0.9;  // free width at which two vehicles can pass each other

Result<World> place_of(const Case& c) {
  const std::uint64_t seed = c.seed;
  if (c.setup.place == scenario::PlaceKind::kTunnel) {
    return sim::tunnel_world(c.setup.tunnel, Rng(seed, "tunnel"));
  }
  World world = sim::make_world(c.setup.scene, seed);
  world.starts.clear();
  world.rounds.clear();
  return world;
}

/// Moves vehicles along one route, each in its own lane, and adds the rounds.
class Planner {
 public:
  Planner(Case& c, const Ranges& ranges, World& world)
      : case_(c),
        ranges_(ranges),
        world_(world),
        rng_(c.seed, "plan"),
        route_(world.route, world.rounding_m) {}

  Status run() {
    const int n = case_.setup.fleet.vehicles;
    if (n == 1) {
      alone();
    } else if (case_.plan == "leap_frog") {
      return leap_frog(n);
    } else if (case_.plan == "together") {
      together(n);
    } else {
      from_anchor(n);
    }
    return {};
  }

 private:
  [[nodiscard]] Vec3 at(double s_m, double side_m) const {
    const double yaw = route_.yaw_at(s_m);
    return route_.point_at(s_m) + side_m * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
  }

  [[nodiscard]] std::vector<Vec3> piece(double from_m, double to_m, double side_m) const {
    constexpr double kStep_m = 0.25;
    constexpr double kTolerance_m = 0.003;
    const double length_m = std::abs(to_m - from_m);
    const int n = std::max(1, static_cast<int>(std::ceil(length_m / kStep_m)));
    std::vector<Vec3> points;
    for (int i = 0; i <= n; ++i) points.push_back(at(from_m + (to_m - from_m) * i / n, side_m));
    return sim::simplified(points, kTolerance_m);
  }

  void start_at(double s_m, double side_m, bool back = false) {
    const double turn = back ? 3.141592653589793 : 0.0;
    world_.starts.push_back({at(s_m, side_m), route_.yaw_at(s_m) + turn});
  }

  /// Lane offset of vehicle v where the path is wide enough for two.
  [[nodiscard]] double lane(int v) const {
    const double offset = std::clamp(world_.free_width_m - 0.4, 0.0, 0.5);
    return v % 2 == 0 ? offset : -offset;
  }

  /// Distance that a vehicle can drive within the recording.
  [[nodiscard]] double reach_m() const {
    const sim::MotionOptions& m = case_.setup.fleet.vehicle.motion;
    return std::max(5.0, (case_.duration_s - m.standstill_s) * m.speed_mps);
  }

  /// A position on the route from which most of the drivable distance remains.
  [[nodiscard]] double start_m(double min_m) {
    const double room_m = std::max(0.0, route_.length_m() - std::max(min_m, reach_m()));
    return rng_.uniform() < 0.5 ? 0.0 : rng_.uniform(0.0, room_m);
  }

  void alone();
  Status leap_frog(int n);
  void together(int n);
  void from_anchor(int n);
  void pause(RoundPlan& round);

  Case& case_;
  const Ranges& ranges_;
  World& world_;
  Rng rng_;
  Route route_;
};

/// Adds a stop before this round with the configured probability.
void Planner::pause(RoundPlan& round) {
  if (!ranges_.happens("motion.stops", rng_)) return;
  const double pause_s = ranges_.number("motion.stop_s", rng_);
  round.pause_s = pause_s;
  case_.stop_s += pause_s;
  case_.features.insert(pause_s > 20.0 ? "long stop" : "stop");
}

void Planner::alone() {
  const double start_m = this->start_m(10.0);
  const double end_m = route_.length_m();
  start_at(start_m, 0.0);
  std::vector<double> cuts{start_m};
  if (ranges_.happens("motion.stops", rng_)) {
    const double until_m = std::min(end_m, start_m + 0.8 * reach_m());
    const int count = ranges_.count("motion.stop_count", rng_);
    for (int i = 0; i < count; ++i) cuts.push_back(rng_.uniform(start_m + 1.0, until_m));
    std::sort(cuts.begin(), cuts.end());
  }
  cuts.push_back(end_m);
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    if (cuts[i] < cuts[i - 1] + 0.5) continue;
    RoundPlan round;
    round.routes.push_back(piece(cuts[i - 1], cuts[i], 0.0));
    round.pause_s = i == 1 ? 0.0 : ranges_.number("motion.stop_s", rng_);
    if (i > 1) {
      case_.stop_s += *round.pause_s;
      case_.features.insert(*round.pause_s > 20.0 ? "long stop" : "stop");
    }
    world_.rounds.push_back(std::move(round));
  }
}

Status Planner::leap_frog(int n) {
  sim::RoundOptions options;
  options.gap_m = ranges_.number("fleet.gap_m", rng_);
  options.leg_m = ranges_.number("fleet.leg_m", rng_);
  World part = world_;
  const double start_m = this->start_m(6.0 * n);
  part.route = piece(start_m, route_.length_m(), 0.0);
  Result<sim::FleetPlan> plan = sim::plan_rounds(part, n, options);
  if (!plan) return tl::make_unexpected(plan.error());
  world_.starts = std::move(plan->starts);
  world_.rounds = std::move(plan->rounds);
  for (RoundPlan& round : world_.rounds) {
    if (rng_.uniform() < 0.3) pause(round);
  }
  return {};
}

/// All vehicles drive at once, one behind the other.
void Planner::together(int n) {
  const double gap_m = ranges_.number("fleet.gap_m", rng_);
  const double start_m = this->start_m(gap_m * n + 10.0);
  const double room_m = route_.length_m() - start_m - gap_m * (n - 1);
  const bool stops = ranges_.happens("motion.stops", rng_);
  const double first_m =
      stops ? std::min(0.9 * room_m, rng_.uniform(0.2, 0.6) * reach_m()) : room_m;
  RoundPlan one, two;
  for (int v = 0; v < n; ++v) {
    const double s = start_m + gap_m * (n - 1 - v);
    start_at(s, lane(v));
    one.routes.push_back(piece(s, s + first_m, lane(v)));
    if (first_m < room_m - 1.0) two.routes.push_back(piece(s + first_m, s + room_m, lane(v)));
  }
  world_.rounds.push_back(std::move(one));
  if (two.routes.empty()) return;
  pause(two);
  world_.rounds.push_back(std::move(two));
}

/// v1 is stationary: at the start of the path, in its middle, or before a bend. The others drive
/// away from it, past it if there is room, and come back.
void Planner::from_anchor(int n) {
  const double gap_m = ranges_.number("fleet.gap_m", rng_);
  const double length_m = route_.length_m();
  double anchor_m = 0.0;
  if (case_.plan == "middle") anchor_m = 0.5 * std::min(length_m, 1.5 * reach_m());
  if (case_.plan == "bend") {
    double maximum = 0.0;
    for (double s = 5.0; s < 0.6 * length_m; s += 0.5) {
      const double bend = std::abs(route_.curvature_at(s + 8.0));
      if (bend > maximum) anchor_m = s;
      maximum = std::max(maximum, bend);
    }
  }
  const bool passes = case_.plan == "middle" && world_.free_width_m > kLaneMin_m;
  const double out_m =
      std::min(length_m - anchor_m - 0.5, std::max(gap_m * n + 3.0, 0.55 * reach_m()));
  start_at(anchor_m, lane(0));
  RoundPlan out, back;
  out.anchor = back.anchor = 0;
  out.routes.emplace_back();
  back.routes.emplace_back();
  for (int v = 1; v < n; ++v) {
    const double from_m =
        passes ? std::max(0.5 * v, anchor_m - gap_m * v) : anchor_m + gap_m * (n - v);
    const double to_m = std::max(from_m + 1.0, anchor_m + out_m - gap_m * (v - 1));
    const double side_m = passes ? lane(1) : lane(v);
    start_at(from_m, side_m);
    out.routes.push_back(piece(from_m, to_m, side_m));
    back.routes.push_back(piece(to_m, anchor_m + gap_m * v, side_m));
  }
  if (ranges_.happens("fleet.moved_anchor", rng_) && !passes) {
    // While the others come back, the anchor drives away without announcing it.
    const double by_m = ranges_.number("fleet.moved_anchor_m", rng_);
    back.anchor = -1;
    back.routes[0] = piece(anchor_m, std::max(0.0, anchor_m - by_m), lane(0));
    if (anchor_m < by_m)
      back.routes[0] = piece(anchor_m, anchor_m + std::min(by_m, 0.7 * gap_m), lane(0));
    case_.features.insert("anchor moves");
  }
  pause(back);
  world_.rounds.push_back(std::move(out));
  world_.rounds.push_back(std::move(back));
}

}  // namespace

Result<World> planned_world(Case& c, const Ranges& ranges) {
  Result<World> world = place_of(c);
  if (!world) return world;
  if (const Status planned = Planner(c, ranges, *world).run(); !planned) {
    return tl::make_unexpected(planned.error());
  }
  return world;
}

}  // namespace rali::campaign
