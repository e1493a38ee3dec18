#include <cmath>
#include <numbers>

#include "rali/base/assert.hpp"
#include "rali/sim/builder.hpp"
#include "rali/sim/floor_plan/floor_plan.hpp"
#include "rali/sim/scenes/scenes.hpp"

namespace rali::sim::scenes {

using geometry::Vec2;
using geometry::Vec3;

namespace {

TriangleMesh mesh_of(const FloorPlan& plan) {
  auto mesh = floor_plan_mesh(plan);
  RALI_ASSERT(mesh.has_value());  // a handful of rectangles
  return std::move(*mesh);
}

/// Closed gates and doors: shallow recesses along both long walls.
void add_gates(FloorPlan& plan, double x_m, double y_m, Rng& rng) {
  for (const bool north : {false, true}) {
    for (double x = rng.uniform(5.0, 9.0); x < x_m - 6.0; x += rng.uniform(9.0, 15.0)) {
      const bool gate = rng.uniform() < 0.5;
      const double width = gate ? 4.0 : 1.1;
      const double depth = gate ? rng.uniform(0.2, 0.5) : 0.1;
      const double y = north ? y_m : -depth;
      plan.areas.push_back(
          {rectangle(x, y, x + width, y + depth), gate ? 4.2 : 2.1, rng.uniform(0.3, 0.7)});
    }
  }
}

/// Machines: a box or a tank with smaller objects beside it, in two rows in the middle.
void add_machines(FloorPlan& plan, double x_m, double y_m, Rng& rng) {
  for (const double row : {0.38, 0.62}) {
    for (double x = 13.0; x < x_m - 13.0; x += rng.uniform(6.0, 9.0)) {
      if (std::abs(x - 0.5 * x_m) < 5.0) continue;  // the aisle across
      const Vec2 at(x, row * y_m + rng.uniform(-1.0, 1.0));
      const double refl = rng.uniform(0.2, 0.8);
      if (rng.uniform() < 0.3) {
        plan.furniture.push_back(
            {at, {}, rng.uniform(0.8, 1.4), 0.0, rng.uniform(2.5, 4.5), 0.0, refl});
        continue;
      }
      const Vec2 size(rng.uniform(2.0, 4.5), rng.uniform(1.2, 2.4));
      const double top = rng.uniform(1.4, 2.6);
      plan.furniture.push_back({at, size, 0.0, 0.0, top, rng.uniform(-0.15, 0.15), refl});
      plan.furniture.push_back({at + Vec2(0.5 * size.x() + rng.uniform(0.4, 0.9), 0.0),
                                {0.6, 0.8},
                                0.0,
                                0.0,
                                rng.uniform(0.9, 1.8),
                                0.0,
                                0.5});
    }
  }
}

/// One double rack along x: uprights, three shelves, goods that differ from bay to bay.
void add_rack(TriangleMesh& mesh, double x0, double x1, double y, double depth_m, Rng& rng) {
  constexpr double kBay_m = 2.7;
  constexpr double kTop_m = 5.0;
  constexpr double kLevel_m = 1.6;
  const int bays = static_cast<int>(std::floor((x1 - x0) / kBay_m));
  for (int i = 0; i <= bays; ++i) {
    for (const double side : {-0.5, 0.5}) {
      mesh.add_box({x0 + i * kBay_m, y + side * (depth_m - 0.1), 0.0}, {0.1, 0.1, kTop_m}, 0.0,
                   0.6);
    }
  }
  for (int level = 1; level <= 3; ++level) {
    mesh.add_box({x0 + 0.5 * bays * kBay_m, y, level * kLevel_m - 0.12},
                 {bays * kBay_m, depth_m, 0.12}, 0.0, 0.5);
  }
  for (int i = 0; i < bays; ++i) {
    for (int level = 0; level <= 2; ++level) {
      if (rng.uniform() < 0.2) continue;  // an empty place
      const double tall = rng.uniform(0.6, 1.3);
      mesh.add_box({x0 + (i + 0.5) * kBay_m + rng.uniform(-0.15, 0.15), y,
                    level * kLevel_m + (level == 0 ? 0.0 : 0.002)},
                   {rng.uniform(1.4, 2.3), depth_m - rng.uniform(0.05, 0.3), tall}, 0.0,
                   rng.uniform(0.2, 0.8));
    }
  }
}

}  // namespace

World hall(Rng rng) {
  World world;
  FloorPlan plan;
  const double x = rng.uniform(50.0, 62.0);
  const double y = rng.uniform(30.0, 36.0);
  const double high = rng.uniform(7.0, 9.5);
  plan.areas.push_back({rectangle(0.0, 0.0, x, y), high, rng.uniform(0.5, 0.7)});
  // Office behind the east wall, with an open door.
  const double office = rng.uniform(0.25, 0.5) * y;
  plan.areas.push_back({rectangle(x + 0.2, office - 3.0, x + 6.2, office + 3.0), 3.0, 0.7});
  plan.areas.push_back({rectangle(x, office - 0.6, x + 0.2, office + 0.6), 2.1, 0.5});
  add_gates(plan, x, y, rng);
  const double pitch = rng.uniform(8.0, 10.0);
  for (double at = 0.5 * pitch; at < x; at += pitch) {  // columns of the roof
    for (const double side : {1.0, y - 1.0}) {
      plan.furniture.push_back({{at, side}, {0.5, 0.5}, 0.0, 0.0, high, 0.0, 0.6});
    }
  }
  add_machines(plan, x, y, rng);
  plan.furniture.push_back({{x + 4.5, office + 1.5}, {1.6, 0.8}, 0.0, 0.0, 0.75, 0.0, 0.6});
  world.mesh = mesh_of(plan);
  const double middle = 0.5 * x;
  world.route = {{5.0, 5.0, 0.0},        {x - 5.0, 5.0, 0.0},         {x - 5.0, y - 5.0, 0.0},
                 {middle, y - 5.0, 0.0}, {middle, 7.5, 0.0},          {7.5, 7.5, 0.0},
                 {7.5, y - 5.0, 0.0},    {middle - 4.0, y - 5.0, 0.0}};
  world.rounding_m = 2.0;
  world.free_width_m = 1.5;
  return world;
}

World warehouse(Rng rng) {
  World world;
  constexpr double kDepth_m = 2.2;  // two racks back to back
  constexpr double kCross_m = 3.5;  // aisles across, at both ends
  const double aisle = rng.uniform(2.7, 3.2);
  const int racks = 4 + static_cast<int>(rng.below(2));
  const double length = 2.7 * static_cast<double>(9 + rng.below(3));
  const double x = length + 2.0 * kCross_m;
  const double y = (racks + 1) * aisle + racks * kDepth_m;
  FloorPlan plan;
  plan.areas.push_back({rectangle(0.0, 0.0, x, y), rng.uniform(6.5, 8.0), 0.6});
  for (int i = 0; i < 3; ++i) {  // loading docks in the west wall
    const double at = (0.2 + 0.3 * i) * y + rng.uniform(-1.0, 1.0);
    plan.areas.push_back({rectangle(-0.6, at - 1.5, 0.0, at + 1.5), 3.2, 0.4});
  }
  world.mesh = mesh_of(plan);
  for (int i = 0; i < racks; ++i) {
    const double middle = aisle + 0.5 * kDepth_m + i * (aisle + kDepth_m);
    add_rack(world.mesh, kCross_m, kCross_m + length, middle, kDepth_m, rng);
  }
  for (int i = 0; i <= racks; ++i) {  // to and fro through all aisles
    const double lane = 0.5 * aisle + i * (aisle + kDepth_m);
    const double from = i % 2 == 0 ? 0.5 * kCross_m : x - 0.5 * kCross_m;
    world.route.emplace_back(from, lane, 0.0);
    world.route.emplace_back(x - from, lane, 0.0);
  }
  world.rounding_m = 1.2;
  world.free_width_m = 0.5 * aisle - 0.5;
  return world;
}

}  // namespace rali::sim::scenes
