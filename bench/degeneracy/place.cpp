#include "place.hpp"

#include <string>

#include "rali/base/rng.hpp"
#include "rali/sim/tunnels/tunnels.hpp"

namespace rali::degeneracy_bench {

namespace {

sim::TunnelOptions any_tunnel(Rng& rng) {
  sim::TunnelOptions o;
  o.curvature_per_m = (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(0.0006, 0.0012);
  o.width_m = rng.uniform(4.0, 6.0);
  o.gradient = rng.uniform(-0.01, 0.01);
  return o;
}

}  // namespace

Result<sim::World> make_place(std::string_view name, std::uint64_t seed) {
  Rng rng(seed, name);
  sim::TunnelOptions o = any_tunnel(rng);
  if (name == "tunnel_niches") {
    o.niche_every_m = rng.uniform(10.0, 25.0);
    return sim::tunnel_world(o, rng);
  }
  if (name == "tunnel_end") {
    o.length_m = 80.0;
    o.closed_ends = true;
    return sim::tunnel_world(o, rng);
  }
  if (name == "tunnel_rough") {
    o.roughness_m = rng.uniform(0.08, 0.20);
    return sim::tunnel_world(o, rng);
  }
  const auto scene = sim::scene_of(name);
  if (scene) return sim::make_world(*scene, seed);
  std::string known;
  for (const std::string_view place : kPlaces) known += " " + std::string(place);
  return fail(ErrorCode::kUsage, {}, "there is no place \"" + std::string(name) + "\"",
              "The places are" + known + " and every other scene of the simulator.");
}

}  // namespace rali::degeneracy_bench
