#pragma once

#include <string>

#include "rali/base/settings.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/sensor/calibration.hpp"

namespace rali::vehicle {

/// Everything one vehicle's software needs to know before its first event.
struct VehicleSettings {
  std::string name = "v1";
  sensor::Calibration calibration;
  bool has_imu = true;  ///< false: LiDAR only, no scan waits for inertial data
  odometry::OdometrySettings odometry;
  double imu_wait_s = 0.2;  ///< how long (data time) a scan waits for inertial data before it goes on without

  template <class V>
  void visit(V& v) {
    v("imu_wait_s", imu_wait_s, 0.0, 5.0, "wait for late inertial data before a scan goes on without");
  }
};

}  // namespace rali::vehicle
