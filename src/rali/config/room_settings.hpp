#pragma once

#include "rali/base/settings.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/node/settings.hpp"
#include "rali/map/settings.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/ranging/settings.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::config {

enum class CheckAction { kError, kWarn, kOff };
inline constexpr ChoiceNames<3> kCheckActionNames{"error", "warn", "off"};

/// Reaction when the data contradict the user's settings.
struct ChecksSettings {
  CheckAction extrinsics = CheckAction::kError;

  template <class V>
  void visit(V& v) {
    v.choice("extrinsics", extrinsics, kCheckActionNames,
             "T_body_lidar against the data: stop, go on with a warning, do not compare");
  }
};

/// The values that fleet.yaml's `settings:` may override, by module.
struct RoomSettings {
  ChecksSettings checks;
  odometry::OdometrySettings odometry;
  map::MapSettings map;              ///< voxel and grid are set by fleet.yaml's `output:`
  ranging::RangingSettings ranging;  ///< sigma and limits are set by fleet.yaml's `ranges:`
  fleet::FleetSettings fleet;        ///< its `ranging` is that of the module
  fleet::NodeSettings mission;       ///< its `fleet` is copied from the one above
  vehicle::VehicleSettings vehicle;  ///< its own fields; odometry and calibration come from above

  template <class V>
  void visit(V& v) {
    v.group("checks", checks, "settings against data");
    v.group("odometry", odometry, "LiDAR-inertial odometry");
    v.group("map", map, "the merged map");
    v.group("ranging", ranging, "ranges between vehicles");
    v.group("fleet", fleet, "the joint map of all vehicles");
    v.group("mission", mission, "who is anchor, when rounds end, where the others go");
    v.group("vehicle", vehicle, "one vehicle's step");
  }
};

}  // namespace rali::config
