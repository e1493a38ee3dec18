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

std::optional<std::size_t> best_reached_twice(std::span<const TriedSpeed> tried, double sigma_mps) {
  constexpr double kSame_mps = 0.05;
  constexpr double kRounding_mps = 1e-6;
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const TriedSpeed& speed = tried[k];
    if (best && !(speed.value > tried[*best].value)) continue;
    const auto leads_there = [&](const TriedSpeed& other) {
      return &other != &speed &&
             std::abs(other.first_mps - speed.first_mps) <= sigma_mps + kRounding_mps &&
             std::abs(other.mean_mps - speed.mean_mps) < kSame_mps;
    };
    if (std::any_of(tried.begin(), tried.end(), leads_there)) best = k;
  }
  return best;
}

}  // namespace rali::odometry
