#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::sensor {

/// Poses of the sensors of one vehicle. Body = IMU unless T_body_imu says otherwise.
struct Calibration {
  geometry::SE3 T_body_lidar;
  geometry::SE3 T_body_imu;
};

}  // namespace rali::sensor
