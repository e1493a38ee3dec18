#include "rali/sim/jolts.hpp"

#include <algorithm>
#include <cmath>

namespace rali::sim {

using geometry::Vec6;

namespace {

constexpr double kSettle_m = 0.08;  // distance over which the height after a joint decays
constexpr double kWheelbase_m = 0.4;

/// 0 before the step, 1 after it, twice differentiable between.
double step_shape(double since_m, double width_m) {
  const double u = std::clamp(since_m / width_m, 0.0, 1.0);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

}  // namespace

void Jolts::Series::extend_to(double distance_m) {
  if (every_m <= 0.0) return;
  // One step beyond the distance: the lag before a slip grows towards the next slip.
  while (at_m.empty() || at_m.back() <= distance_m) {
    at_m.push_back((at_m.empty() ? 0.0 : at_m.back()) + every_m * rng.uniform(0.6, 1.4));
    by_m.push_back(size_m * rng.normal());
  }
}

std::ptrdiff_t Jolts::Series::last_before(double distance_m) const {
  return std::upper_bound(at_m.begin(), at_m.end(), distance_m) - at_m.begin() - 1;
}

Jolts::Jolts(const JoltOptions& options, std::uint64_t seed)
    : options_(options),
      joints_(options.joint_every_m, options.joint_m, Rng(seed, "joints")),
      slips_(options.slip_every_m, options.slip_m, Rng(seed, "slips")) {
  extend_to(0.0);
}

void Jolts::extend_to(double distance_m) {
  joints_.extend_to(distance_m);
  slips_.extend_to(distance_m);
}

Vec6 Jolts::at(double distance_m, double speed_mps) const {
  const double width_m = std::max(1e-4, options_.step_s * speed_mps);
  Vec6 out = Vec6::Zero();
  if (const std::ptrdiff_t k = joints_.last_before(distance_m); k >= 0) {
    const auto i = static_cast<std::size_t>(k);
    const double since_m = distance_m - joints_.at_m[i];
    const double height_m =
        joints_.by_m[i] * step_shape(since_m, width_m) * std::exp(-since_m / kSettle_m);
    out[2] = height_m;
    out[4] = height_m / kWheelbase_m;
  }
  const std::ptrdiff_t k = slips_.last_before(distance_m);
  if (slips_.every_m > 0.0) {
    // Between two slips the lag of the body grows; the slip removes it.
    const auto next = static_cast<std::size_t>(k + 1);
    const double from_m = k >= 0 ? slips_.at_m[static_cast<std::size_t>(k)] : 0.0;
    const double lag_m =
        -std::abs(slips_.by_m[next]) * (distance_m - from_m) / (slips_.at_m[next] - from_m);
    const double left_m = k >= 0 ? -std::abs(slips_.by_m[static_cast<std::size_t>(k)]) : 0.0;
    out[0] = lag_m + left_m * (1.0 - step_shape(distance_m - from_m, width_m));
  }
  return out;
}

}  // namespace rali::sim
