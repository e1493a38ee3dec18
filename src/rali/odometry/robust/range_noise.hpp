#pragma once

#include <optional>

#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// Standard deviation of a range [m], measured in one scan: the deviation from a line of three
/// consecutive returns of a laser on a smooth surface. Nothing if rings are not known or too few
/// triples lie on surfaces.
[[nodiscard]] std::optional<double> measure_range_noise(const sensor::LidarScan& scan);

}  // namespace rali::odometry
