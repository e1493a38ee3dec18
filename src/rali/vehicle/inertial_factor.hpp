#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/graph/factors.hpp"
#include "rali/imu/preintegration.hpp"
#include "rali/odometry/imu_noise.hpp"

namespace rali::vehicle {

/// The graph's factor of preintegrated samples; whose keyframes and gravity the caller fills in.
[[nodiscard]] graph::InertialFactor inertial_factor(const imu::Preintegration& sum,
                                                    const odometry::ImuNoiseSettings& noise,
                                                    const geometry::SE3& T_body_imu);

}  // namespace rali::vehicle
