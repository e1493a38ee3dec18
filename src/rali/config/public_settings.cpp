#include "rali/config/public_settings.hpp"

#include <algorithm>
#include <array>

namespace rali::config {
namespace {

using Keys = std::string_view;

constexpr std::array kInput{Keys{"schema"},
                            Keys{"preset"},
                            Keys{"vehicles.v1.recording"},
                            Keys{"vehicles.v1.start_s"},
                            Keys{"vehicles.v1.duration_s"},
                            Keys{"vehicles.v1.lidar.topic"},
                            Keys{"vehicles.v1.imu.topic"},
                            Keys{"vehicles.v1.imu.file"}};

constexpr std::array kMounting{
    Keys{"vehicles.v1.lidar.T_body_lidar"}, Keys{"vehicles.v1.imu.T_body_imu"},
    Keys{"settings.odometry.robust.mounting_sigma_deg"}, Keys{"settings.checks.extrinsics"}};

constexpr std::array kTiming{Keys{"vehicles.v1.lidar.model"}, Keys{"vehicles.v1.lidar.point_time"},
                             Keys{"vehicles.v1.lidar.header_stamp"},
                             Keys{"vehicles.v1.lidar.deskewed"},
                             Keys{"vehicles.v1.lidar.time_offset_s"}};

constexpr std::array kPoints{Keys{"vehicles.v1.self_box_m"}, Keys{"vehicles.v1.lidar.range_m"},
                             Keys{"vehicles.v1.lidar.returns"},
                             Keys{"settings.odometry.robust.range_sigma_m"}};

constexpr std::array kImu{Keys{"vehicles.v1.imu.model"}, Keys{"vehicles.v1.imu.accel_unit"},
                          Keys{"vehicles.v1.imu.gyro_unit"},
                          Keys{"vehicles.v1.imu.vibration_factor"}};

constexpr std::array kMotion{Keys{"settings.odometry.robust.carrier"},
                             Keys{"settings.odometry.robust.constraints.standstill"},
                             Keys{"settings.odometry.robust.constraints.non_holonomic"},
                             Keys{"settings.odometry.robust.constraints.ground"},
                             Keys{"settings.odometry.robust.constraints.speed_max_mps"}};

constexpr std::array kSize{Keys{"settings.odometry.robust.sampling.update_points"},
                           Keys{"settings.odometry.robust.map.voxel_m"},
                           Keys{"settings.odometry.robust.keyframe.distance_m"},
                           Keys{"output.map_voxel_m"}, Keys{"settings.map.max_memory_mb"}};

constexpr std::array kRanges{Keys{"ranges.sources"},       Keys{"ranges.stamp"},
                             Keys{"ranges.latency_s"},     Keys{"ranges.sigma_m"},
                             Keys{"ranges.bias_m"},        Keys{"ranges.limits_m"},
                             Keys{"vehicles.v1.antennas"}, Keys{"settings.ranging.use"}};

constexpr std::array kJoin{Keys{"priors"}, Keys{"clock"}, Keys{"vehicles.v1.clock_offset_s"},
                           Keys{"settings.fleet.join"}};

constexpr std::array kLoops{Keys{"settings.fleet.loops.use"}};

constexpr std::array kMoving{Keys{"settings.map.dynamic.remove"},
                             Keys{"settings.map.dynamic.peer_radius_m"},
                             Keys{"settings.vehicle.peer_mask.use"}};

constexpr std::array kGrid{Keys{"output.grid.cell_m"}, Keys{"output.grid.z_m"},
                           Keys{"settings.map.grid.make"},
                           Keys{"settings.map.grid.ground_below_body_m"}};

constexpr std::array kSite{Keys{"output.frame"}, Keys{"output.georeference"}};

constexpr std::array kRounds{Keys{"rounds"}, Keys{"radio.file"},
                             Keys{"settings.mission.explore.vehicle_radius_m"}};

constexpr std::array kGroups{
    SymptomGroup{"The recording is not read, or not all of it",
                 "Only `recording` is needed. Name the topics where a recording has several.",
                 kInput},
    SymptomGroup{"Walls are bent or doubled from the first metres on",
                 "The pose of a sensor in the body is wrong. Measure it, or leave `auto`.",
                 kMounting},
    SymptomGroup{"The map is doubled after fast turns",
                 "Points or scans have wrong times. `rali doctor` shows what is read.", kTiming},
    SymptomGroup{"The vehicle itself is in the map, or walls are thick",
                 "Remove the own structure and points that the sensor measures badly.", kPoints},
    SymptomGroup{"The start fails, or the pose drifts on a vibrating vehicle",
                 "Choose the model of the IMU, then look at `D10` of `rali doctor`.", kImu},
    SymptomGroup{"The sensors are carried by a person or a drone, or the vehicle slips",
                 "Set the carrier; it sets the constraints.", kMotion},
    SymptomGroup{"Mapping is too slow, or the map is too coarse or too large",
                 "Take fewer points for speed, smaller voxels for narrow places.", kSize},
    SymptomGroup{"Ranges are rejected, or they shift the map",
                 "Check antennas and stamps first, then noise and bias.", kRanges},
    SymptomGroup{"Vehicles are not in one map", "Give start poses, or check the clocks.", kJoin},
    SymptomGroup{"Places seen twice do not coincide, or different places are joined",
                 "Compare more submaps, or switch loop closures off to compare.", kLoops},
    SymptomGroup{"People or vehicles are in the map, or fixed things are missing",
                 "`removed.pcd` holds what was removed.", kMoving},
    SymptomGroup{"The grid for navigation has holes, or obstacles that do not exist",
                 "Adapt the height band to the ground.", kGrid},
    SymptomGroup{"The map must be in another frame", "", kSite},
    SymptomGroup{"Rounds or anchors are not as they were driven",
                 "Give a table of rounds, or the signal strengths.", kRounds},
};

constexpr std::string_view kVehicles = "vehicles.";

/// Whether two keys of vehicles are the same after the vehicle's name.
bool same_key(std::string_view listed, std::string_view key) {
  if (!listed.starts_with(kVehicles) || !key.starts_with(kVehicles)) return listed == key;
  const std::size_t after = key.find('.', kVehicles.size());
  return after != std::string_view::npos &&
         key.substr(after) == listed.substr(listed.find('.', kVehicles.size()));
}

}  // namespace

std::span<const SymptomGroup> public_settings() { return kGroups; }

bool is_public_setting(std::string_view key) {
  return std::any_of(kGroups.begin(), kGroups.end(), [&](const SymptomGroup& group) {
    return std::any_of(group.keys.begin(), group.keys.end(),
                       [&](std::string_view listed) { return same_key(listed, key); });
  });
}

}  // namespace rali::config
