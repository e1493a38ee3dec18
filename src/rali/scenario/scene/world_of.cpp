#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "rali/scenario/scene/place_world.hpp"
#include "rali/scenario/scene/scene_setup.hpp"
#include "rali/scenario/scene/surveyor.hpp"
#include "rali/sim/route.hpp"

namespace rali::scenario {

using geometry::Vec3;

namespace {

/// Creates starts and rounds of a world from the contents of the file.
class FleetPlacer {
 public:
  FleetPlacer(const SceneSetup& setup, sim::World& world)
      : setup_(setup), world_(world), surveyor_(world.mesh) {}

  Status place() {
    constexpr double kRounding_m = 0.5;  // hand-drawn paths come close to walls
    if (setup_.vehicles.empty() && setup_.rounds.empty()) return place_default();
    if (setup_.place == PlaceKind::kFloorPlan || setup_.place == PlaceKind::kMesh) {
      world_.rounding_m = kRounding_m;
    }
    if (auto status = find_starts(); !status) return status;
    world_.rounds.clear();
    if (auto status = setup_.rounds.empty() ? single_round() : given_rounds(); !status) {
      return status;
    }
    choose_route();
    set_headings();
    return {};
  }

  /// All paths, so that clutter keeps away from them.
  [[nodiscard]] std::vector<Path> paths() const {
    std::vector<Path> all{world_.route};
    for (const sim::RoundPlan& round : world_.rounds) {
      all.insert(all.end(), round.routes.begin(), round.routes.end());
    }
    for (const sim::VehicleStart& start : world_.starts) {
      all.push_back({start.p_world_m, start.p_world_m + Vec3(0.01, 0.0, 0.0)});
    }
    return all;
  }

 private:
  [[nodiscard]] std::string where_of(std::size_t i, const std::string& line) const {
    return line.empty() ? fmt::format("{}: {}", setup_.name, vehicle_name(static_cast<int>(i)))
                        : line;
  }

  Status place_default() {
    if (world_.route.empty()) {
      if (setup_.place == PlaceKind::kMesh) {
        return fail(ErrorCode::kUsage, setup_.name, "a mesh does not say where a vehicle starts",
                    "Give `vehicles: [{start: [x, y]}]`.");
      }
      world_.rounding_m = 0.5;
      world_.free_width_m = 0.4;
      auto plan = floor_plan_of(setup_.floor_plan);
      if (!plan) return tl::make_unexpected(plan.error());
      const auto inside = [&](const Vec3& p) {
        return p.z() < 0.3 && sim::area_at(plan->areas, p.head<2>()) != nullptr;
      };
      auto path = surveyor_.longest(Vec3::Constant(std::nan("")), inside, setup_.name);
      if (!path) return tl::make_unexpected(path.error());
      world_.route = std::move(*path);
      if (auto status =
              surveyor_.check_path(world_.route, world_.rounding_m, "the fleet", setup_.name);
          !status) {
        return status;
      }
    }
    auto placed = sim::world_for(world_, setup_.fleet.vehicles);
    if (!placed) {
      Error error = placed.error();
      error.where = setup_.name + ": " + error.where;
      return tl::make_unexpected(std::move(error));
    }
    world_.starts = std::move(placed->starts);
    world_.rounds = std::move(placed->rounds);
    return {};
  }

  Status find_starts() {
    std::vector<sim::VehicleStart> starts;
    const auto n = static_cast<std::size_t>(setup_.fleet.vehicles);
    std::vector<sim::VehicleStart> shipped;
    if (setup_.vehicles.size() < n) {
      auto placed = sim::world_for(world_, setup_.fleet.vehicles);
      if (!placed) return tl::make_unexpected(placed.error());
      shipped = std::move(placed->starts);
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i >= setup_.vehicles.size()) {
        starts.push_back(shipped[i]);
        continue;
      }
      const SceneVehicle& vehicle = setup_.vehicles[i];
      const bool given = is_given(vehicle.start);
      const std::string where = where_of(i, given ? vehicle.start_where : vehicle.where);
      if (!given && vehicle.route.empty()) {
        return fail(
            ErrorCode::kUsage, where,
            fmt::format("{} has neither start nor route", vehicle_name(static_cast<int>(i))),
            "Give `start: [x, y]`.");
      }
      const auto p = surveyor_.on_ground(given ? vehicle.start : vehicle.route.front(),
                                         vehicle_name(static_cast<int>(i)), where);
      if (!p) return tl::make_unexpected(p.error());
      starts.push_back({*p, vehicle.yaw_deg.value_or(0.0) * std::numbers::pi / 180.0});
    }
    world_.starts = std::move(starts);
    std::vector<Vec3> at;
    for (const sim::VehicleStart& start : world_.starts) at.push_back(start.p_world_m);
    return check_apart(at, "start", "");
  }

  /// Checks that no two vehicles are at one position.
  Status check_apart(const std::vector<Vec3>& at, std::string_view when,
                     const std::string& line) const {
    for (std::size_t i = 0; i < at.size(); ++i) {
      for (std::size_t j = i + 1; j < at.size(); ++j) {
        const double apart = (at[j] - at[i]).norm();
        if (apart >= 2.0 * surveyor_.radius_m()) continue;
        const std::string own = j < setup_.vehicles.size() ? setup_.vehicles[j].where : "";
        return fail(
            ErrorCode::kUsage, where_of(j, line.empty() ? own : line),
            fmt::format("{} and {} are {:.2f} m apart at the {}; they need {:.2f} m",
                        vehicle_name(static_cast<int>(i)), vehicle_name(static_cast<int>(j)), apart,
                        when, 2.0 * surveyor_.radius_m()));
      }
    }
    return {};
  }

  Result<Path> checked(const Path& path, const Vec3& from, std::size_t i,
                       const std::string& where) {
    const std::string name = vehicle_name(static_cast<int>(i));
    auto grounded = surveyor_.along_ground(path, from, name, where);
    if (!grounded) return grounded;
    if (auto status = surveyor_.check_path(*grounded, world_.rounding_m, name, where); !status) {
      return tl::make_unexpected(status.error());
    }
    return grounded;
  }

  /// Routes and goals of the vehicles; a single vehicle without any drives the longest path.
  Status single_round() {
    sim::RoundPlan round;
    round.routes.resize(world_.starts.size());
    std::vector<Vec3> ends;
    bool moves = false;
    for (std::size_t i = 0; i < world_.starts.size(); ++i) {
      const SceneVehicle& vehicle = setup_.vehicles[i];
      const Vec3 from = world_.starts[i].p_world_m;
      const std::string where = where_of(i, vehicle.path_where);
      Path path = vehicle.route;
      if (path.empty() && is_given(vehicle.goal)) {
        const auto to =
            surveyor_.on_ground(vehicle.goal, vehicle_name(static_cast<int>(i)) + "'s goal", where);
        if (!to) return tl::make_unexpected(to.error());
        auto planned = surveyor_.planned(from, *to, where);
        if (!planned) return tl::make_unexpected(planned.error());
        path = std::move(*planned);
      } else if (path.empty() && world_.starts.size() == 1) {
        auto longest = surveyor_.longest(
            from, [](const Vec3&) { return true; }, where);
        if (!longest) return tl::make_unexpected(longest.error());
        path = std::move(*longest);
      }
      ends.push_back(from);
      if (path.empty()) continue;
      auto route = checked(path, from, i, where);
      if (!route) return tl::make_unexpected(route.error());
      ends.back() = route->back();
      round.routes[i] = std::move(*route);
      moves = true;
    }
    if (moves) world_.rounds.push_back(std::move(round));
    return check_apart(ends, "end of their ways", "");
  }

  /// The number of vehicles may have been changed since the rounds were read (--vehicles).
  Status check_named(const SceneRound& given) const {
    std::size_t named = given.anchor < 0 ? 0 : static_cast<std::size_t>(given.anchor) + 1;
    for (std::size_t i = 0; i < given.routes.size(); ++i) {
      if (!given.routes[i].empty()) named = std::max(named, i + 1);
    }
    if (named <= world_.starts.size()) return {};
    return fail(ErrorCode::kUsage, given.where,
                fmt::format("a round names {}, but vehicles is {}",
                            vehicle_name(static_cast<int>(named) - 1), world_.starts.size()),
                "Ask for more vehicles, or take it out of the rounds.");
  }

  Status given_rounds() {
    std::vector<Vec3> at;
    for (const sim::VehicleStart& start : world_.starts) at.push_back(start.p_world_m);
    for (const SceneRound& given : setup_.rounds) {
      if (auto status = check_named(given); !status) return status;
      sim::RoundPlan round;
      round.anchor = given.anchor;
      round.pause_s = given.pause_s;
      round.routes.resize(at.size());
      for (std::size_t i = 0; i < std::min(at.size(), given.routes.size()); ++i) {
        if (given.routes[i].empty()) continue;
        auto route = checked(given.routes[i], at[i], i, where_of(i, given.route_where[i]));
        if (!route) return tl::make_unexpected(route.error());
        at[i] = route->back();
        round.routes[i] = std::move(*route);
      }
      if (auto status = check_apart(at, "end of a round", given.where); !status) return status;
      world_.rounds.push_back(std::move(round));
    }
    return {};
  }

  /// Pedestrians walk along the path of the first vehicle that moves.
  void choose_route() {
    Path all;
    for (std::size_t i = 0; i < world_.starts.size() && all.empty(); ++i) {
      for (const sim::RoundPlan& round : world_.rounds) {
        all.insert(all.end(), round.routes[i].begin(), round.routes[i].end());
      }
    }
    const Vec3 p = world_.starts.front().p_world_m;
    if (all.empty()) all = {p, p + Vec3(0.5, 0.0, 0.0)};
    world_.route = std::move(all);
    world_.free_width_m = std::min(world_.free_width_m, 0.6);
  }

  void set_headings() {
    for (std::size_t i = 0; i < setup_.vehicles.size(); ++i) {
      if (setup_.vehicles[i].yaw_deg) continue;
      for (const sim::RoundPlan& round : world_.rounds) {
        if (round.routes[i].size() < 2) continue;
        world_.starts[i].yaw_rad = sim::Route(round.routes[i], world_.rounding_m).yaw_at(0.0);
        break;
      }
    }
  }

  const SceneSetup& setup_;
  sim::World& world_;
  Surveyor surveyor_;
};

}  // namespace

Result<sim::World> world_of(const SceneSetup& setup) {
  auto world = place_world(setup);
  if (!world) return world;
  FleetPlacer placer(setup, *world);
  if (auto status = placer.place(); !status) return tl::make_unexpected(status.error());
  if (setup.place == PlaceKind::kFloorPlan) {
    add_clutter(setup.floor_plan, placer.paths(), setup.fleet.vehicle.seed, world->mesh);
  }
  return world;
}

}  // namespace rali::scenario
