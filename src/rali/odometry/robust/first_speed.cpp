#include "rali/odometry/robust/first_speed.hpp"

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

}  // namespace rali::odometry
