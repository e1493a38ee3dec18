#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/graph/factors.hpp"
#include "rali/imu/preintegration.hpp"
#include "rali/odometry/imu_noise.hpp"

namespace rali::vehicle {

/// The graph factor of preintegrated samples. The caller fills in its keyframes and gravity.
[[nodiscard]] graph::InertialFactor inertial_factor(const imu::Preintegration& sum,
                                                    const odometry::ImuNoiseSettings& noise,
                                                    const geometry::SE3& T_body_imu);

}  // namespace rali::vehicle
