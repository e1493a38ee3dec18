#include "rali/vehicle/noise_tally.hpp"

#include <cmath>

namespace rali::vehicle {

void NoiseTally::add(const imu::MeasuredNoise& now) {
  const auto add_to = [](LogMean& mean, const std::optional<double>& value) {
    if (!value || !(*value > 0.0)) return;
    mean.sum += std::log(*value);
    ++mean.n;
  };
  add_to(gyro_, now.gyro_radps_rthz);
  add_to(accel_, now.accel_mps2_rthz);
}

imu::MeasuredNoise NoiseTally::mean() const {
  const auto mean_of = [](const LogMean& mean) -> std::optional<double> {
    if (mean.n == 0) return std::nullopt;
    return std::exp(mean.sum / mean.n);
  };
  return {mean_of(gyro_), mean_of(accel_)};
}

}  // namespace rali::vehicle
