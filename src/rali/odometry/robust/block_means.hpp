#pragma once

#include <vector>

#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// Means over blocks of 0.1 s: white noise of a good sensor at 200 Hz has more spread than slow
/// driving, its block means have not.
[[nodiscard]] std::vector<sensor::ImuSample> block_means(
    const std::vector<sensor::ImuSample>& samples);

}  // namespace rali::odometry
