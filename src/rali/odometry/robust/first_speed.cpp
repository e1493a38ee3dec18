#include "rali/odometry/robust/first_speed.hpp"

#include <algorithm>
#include <cmath>

namespace rali::odometry {

double value_of(const FirstSpeedFit& fit) {
  constexpr double kFacing = 3.0;
  constexpr double kNis = 10.0;
  constexpr double kSigma = 0.15;
  constexpr double kNoPoint = 1e-6;
  return std::log(kNoPoint + fit.on_walls + kFacing * fit.on_facing) -
         (fit.nis + fit.sideways) / kNis - kSigma * std::log(fit.speed_sigma_mps);
}

namespace {

bool is_reached_twice(std::span<const TriedSpeed> tried, const TriedSpeed& speed,
                      double sigma_mps) {
  constexpr double kSame_mps = 0.05;
  constexpr double kRounding_mps = 1e-6;
  return std::any_of(tried.begin(), tried.end(), [&](const TriedSpeed& other) {
    return &other != &speed &&
           std::abs(other.first_mps - speed.first_mps) <= sigma_mps + kRounding_mps &&
           std::abs(other.mean_mps - speed.mean_mps) < kSame_mps;
  });
}

}  // namespace

std::optional<std::size_t> best_speed(std::span<const TriedSpeed> tried, double sigma_mps) {
  constexpr double kAboutAsGood = 0.1;  // a tenth of the points
  if (tried.empty()) return std::nullopt;
  const auto value = [&](const TriedSpeed& speed) {
    return speed.value - (is_reached_twice(tried, speed, sigma_mps) ? 0.0 : kAboutAsGood);
  };
  const auto best = std::max_element(
      tried.begin(), tried.end(),
      [&](const TriedSpeed& a, const TriedSpeed& b) { return value(a) < value(b); });
  return static_cast<std::size_t>(best - tried.begin());
}

}  // namespace rali::odometry
