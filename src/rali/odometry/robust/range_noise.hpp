#pragma once

#include <optional>

#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// Standard deviation of a range [m], measured in one scan: by how much three returns that a laser
/// gives one after the other on a smooth surface miss a line. Nothing where rings are not known or
/// too few triples lie on surfaces.
[[nodiscard]] std::optional<double> measure_range_noise(const sensor::LidarScan& scan);

}  // namespace rali::odometry
