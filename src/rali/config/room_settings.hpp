#pragma once

#include "rali/odometry/settings.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::config {

/// What fleet.yaml's `settings:` may override, by room.
struct RoomSettings {
  odometry::OdometrySettings odometry;
  vehicle::VehicleSettings vehicle;  ///< its own fields; odometry and calibration come from above

  template <class V>
  void visit(V& v) {
    v.group("odometry", odometry, "LiDAR-inertial odometry");
    v.group("vehicle", vehicle, "one vehicle's step");
  }
};

}  // namespace rali::config
