#include "rali/odometry/robust/block_means.hpp"

namespace rali::odometry {

using geometry::Vec3;
using sensor::ImuSample;

std::vector<ImuSample> block_means(const std::vector<ImuSample>& samples) {
  constexpr std::int64_t kBlock_ns = 100'000'000;
  std::vector<ImuSample> out;
  std::size_t k = 0;
  while (k < samples.size()) {
    ImuSample mean{samples[k].t, Vec3::Zero(), Vec3::Zero()};
    std::size_t n = 0;
    while (k < samples.size() && samples[k].t.ns - mean.t.ns < kBlock_ns) {
      mean.gyro_radps += samples[k].gyro_radps;
      mean.accel_mps2 += samples[k].accel_mps2;
      ++k;
      ++n;
    }
    mean.gyro_radps /= static_cast<double>(n);
    mean.accel_mps2 /= static_cast<double>(n);
    out.push_back(mean);
  }
  return out;
}

}  // namespace rali::odometry
