#include "starts.hpp"

#include <cmath>
#include <numbers>

#include "rali/base/rng.hpp"
#include "rali/fleet/path/level.hpp"

namespace rali::fleet_bench {

using geometry::SE3;

namespace {

constexpr double kTapeSigma_m = 0.2;
constexpr double kCompassSigma_rad = 3.0 * std::numbers::pi / 180.0;

/// Upright, with the heading of the body.
SE3 levelled(const SE3& T_world_body) {
  return fleet::level_start(T_world_body, geometry::Vec3::UnitZ());
}

}  // namespace

std::vector<fleet::GivenStart> starts_by_hand(const std::vector<SE3>& T_world_start,
                                              std::uint64_t seed) {
  std::vector<fleet::GivenStart> starts;
  if (T_world_start.empty()) return starts;
  Rng rng(seed, "start poses");
  const SE3 T_first = levelled(T_world_start.front());
  for (std::size_t v = 1; v < T_world_start.size(); ++v) {
    fleet::GivenStart start;
    start.relative_to = VehicleId{0};
    start.vehicle = VehicleId{static_cast<std::uint16_t>(v)};
    start.sigma_m = kTapeSigma_m;
    start.sigma_rad = kCompassSigma_rad;
    start.T_relative_vehicle = T_first.inverse() * levelled(T_world_start[v]);
    for (double& x : start.T_relative_vehicle.p) x += kTapeSigma_m * rng.normal();
    start.T_relative_vehicle.R =
        geometry::rotation_from_rpy(0.0, 0.0, kCompassSigma_rad * rng.normal()) *
        start.T_relative_vehicle.R;
    starts.push_back(start);
  }
  return starts;
}

}  // namespace rali::fleet_bench
