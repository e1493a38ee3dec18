#include <cmath>
#include <numbers>

#include <fmt/core.h>

#include "rali/sim/builder.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPerTurn = 48;

/// The lane: floor, ceiling, inner and outer wall, posts.
class Helix {
 public:
  explicit Helix(const RampOptions& options) : o_(options) {}

  [[nodiscard]] Vec3 ground(double turns, double r) const {
    const double angle = 2.0 * kPi * turns - 0.5 * kPi;
    return {r * std::cos(angle), r * std::sin(angle), o_.rise_m * turns};
  }

  void add_to(TriangleMesh& mesh) const {
    const double inner = o_.radius_m - 0.5 * o_.width_m;
    const double outer = o_.radius_m + 0.5 * o_.width_m;
    for (int i = 0; i < o_.turns * kPerTurn; ++i) {
      const double a = static_cast<double>(i) / kPerTurn;
      const double b = static_cast<double>(i + 1) / kPerTurn;
      for (const double lift : {0.0, o_.height_m}) {  // floor and ceiling
        const std::uint32_t p = mesh.add_vertex(ground(a, inner) + Vec3(0, 0, lift));
        const std::uint32_t q = mesh.add_vertex(ground(a, outer) + Vec3(0, 0, lift));
        const std::uint32_t r = mesh.add_vertex(ground(b, outer) + Vec3(0, 0, lift));
        const std::uint32_t s = mesh.add_vertex(ground(b, inner) + Vec3(0, 0, lift));
        mesh.add_triangle(p, q, r, 0.4);
        mesh.add_triangle(p, r, s, 0.4);
      }
      for (const double r : {inner, outer}) {  // walls
        mesh.add_quad(ground(a, r), ground(b, r) - ground(a, r), {0.0, 0.0, o_.height_m}, 0.6);
      }
      if (i % 6 == 0) mesh.add_cylinder(ground(a, outer - 0.15), 0.12, o_.height_m, 8, 0.5);
    }
  }

 private:
  RampOptions o_;
};

/// A level hall, open towards the ramp: the lower one lies west, the upper one east.
void add_hall(Builder& build, const RampOptions& o, bool above) {
  const double z = above ? o.rise_m * o.turns : 0.0;
  const double x0 = above ? 0.0 : -14.0;
  const double x1 = above ? 14.0 : 0.0;
  const double y0 = -o.radius_m - 6.0;
  const double y1 = -o.radius_m + 6.0;
  const double high = o.height_m;
  build.slab(x0, y0, x1, y1, z);
  build.slab(x0, y0, x1, y1, z + high, 0.7);
  build.lived_in_wall({x0, y0, z}, {x1, y0, z}, high, 4.0, 0.0);
  build.lived_in_wall({x1, y1, z}, {x0, y1, z}, high, 4.0, 0.0);
  build.lived_in_wall({above ? x1 : x0, above ? y0 : y1, z}, {above ? x1 : x0, above ? y1 : y0, z},
                      high, 4.0, 0.0);
  build.furnish({x0 + (above ? 8.0 : 1.0), y0 + 0.5, z}, {5.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, 4);
}

}  // namespace

Result<World> ramp_world(const RampOptions& o, Rng rng) {
  if (o.rise_m < o.height_m + 0.2 || o.radius_m < 0.5 * o.width_m + 1.0) {
    return fail(ErrorCode::kUsage, "ramp",
                fmt::format("rises {:.2f} m per turn of {:.2f} m radius, but its lane is {:.2f} m "
                            "high and {:.2f} m wide",
                            o.rise_m, o.radius_m, o.height_m, o.width_m),
                "The rise must be 0.2 m above height_m, the radius 1 m above half of width_m.");
  }
  World world;
  Builder build(world.mesh, rng);
  const Helix helix(o);
  helix.add_to(world.mesh);
  add_hall(build, o, false);
  add_hall(build, o, true);
  world.route.emplace_back(-11.0, -o.radius_m, 0.0);
  for (int i = 0; i <= o.turns * 24; ++i) {
    world.route.push_back(helix.ground(i / 24.0, o.radius_m));
  }
  world.route.emplace_back(11.0, -o.radius_m, o.rise_m * o.turns);
  world.rounding_m = 2.0;
  world.free_width_m = 0.5 * o.width_m - 0.9;
  return world;
}

}  // namespace rali::sim
