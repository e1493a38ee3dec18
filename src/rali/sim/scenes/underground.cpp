#include "rali/base/assert.hpp"
#include "rali/sim/scenes/scenes.hpp"
#include "rali/sim/tunnels/drift.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::sim::scenes {

World tunnel(Rng rng) {
  TunnelOptions o;
  o.curvature_per_m = (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(0.0006, 0.0012);
  o.width_m = rng.uniform(4.4, 5.6);
  o.gradient = rng.uniform(-0.01, 0.01);
  auto world = tunnel_world(o, rng);
  RALI_ASSERT(world.has_value());  // bent by 14 deg at most
  return std::move(*world);
}

World mine(Rng rng) {
  const double turn = rng.uniform() < 0.5 ? -1.0 : 1.0;
  const std::uint64_t seed = rng.next();
  const double height = rng.uniform(0.8, 1.4);
  const Route drift({{-4, 0, 0},
                     {30, 4 * turn, 0},
                     {48, 22 * turn, 0},
                     {74, 26 * turn, 0.6},
                     {100, 14 * turn, 1.2}},
                    8.0);
  return drift_world(drift, {{2.2, height}, 0.30, 6.5}, seed, rng);
}

World ramp(Rng rng) {
  RampOptions o;
  o.radius_m = rng.uniform(8.0, 10.0);
  o.rise_m = rng.uniform(2.8, 3.2);
  auto world = ramp_world(o, rng);
  RALI_ASSERT(world.has_value());
  return std::move(*world);
}

}  // namespace rali::sim::scenes
