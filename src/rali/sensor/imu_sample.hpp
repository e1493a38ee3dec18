#pragma once

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::sensor {

/// One inertial measurement in the IMU frame, SI units.
struct ImuSample {
  Time t;
  geometry::Vec3 gyro_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_mps2 =
      geometry::Vec3::Zero();  ///< specific force: at standstill, z up: +9.81 in z
};

}  // namespace rali::sensor
