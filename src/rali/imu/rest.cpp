#include "rali/imu/rest.hpp"

#include "rali/geometry/so3.hpp"

namespace rali::imu {

using geometry::Vec3;

ImuStatistics statistics(std::span<const sensor::ImuSample> samples) {
  ImuStatistics out;
  out.samples = static_cast<int>(samples.size());
  if (samples.empty()) return out;
  const double n = static_cast<double>(samples.size());
  if (samples.size() > 1) {
    out.period_s = seconds_between(samples.front().t, samples.back().t) / (n - 1.0);
  }
  for (const sensor::ImuSample& s : samples) {
    out.gyro_mean_radps += s.gyro_radps / n;
    out.accel_mean_mps2 += s.accel_mps2 / n;
  }
  Vec3 gyro2 = Vec3::Zero();
  Vec3 accel2 = Vec3::Zero();
  for (const sensor::ImuSample& s : samples) {
    gyro2 += (s.gyro_radps - out.gyro_mean_radps).cwiseAbs2() / n;
    accel2 += (s.accel_mps2 - out.accel_mean_mps2).cwiseAbs2() / n;
  }
  out.gyro_sd_radps = gyro2.cwiseSqrt();
  out.accel_sd_mps2 = accel2.cwiseSqrt();
  return out;
}

bool is_rest(const ImuStatistics& stats, const RestSettings& settings) {
  // Axis by axis, because maxCoeff() ignores NaN.
  return stats.samples >= 10 && (stats.gyro_sd_radps.array() < settings.gyro_sd_max_radps).all() &&
         (stats.accel_sd_mps2.array() < settings.accel_sd_max_mps2).all() &&
         stats.gyro_mean_radps.norm() < settings.gyro_mean_max_radps;
}

geometry::Mat3 level(const Vec3& accel_mean_mps2) {
  return geometry::rotation_between(accel_mean_mps2, Vec3::UnitZ());
}

}  // namespace rali::imu
