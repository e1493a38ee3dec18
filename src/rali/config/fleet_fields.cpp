#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/codecs.hpp"
#include "rali/config/fleet_config.hpp"
#include "rali/config/fleet_lists.hpp"
#include "rali/config/imu_models.hpp"
#include "rali/config/presets.hpp"
#include "rali/config/public_settings.hpp"
#include "rali/sensor/lidar_models.hpp"

namespace rali::config {
namespace {

constexpr double kWeek_s = 7.0 * 86400.0;

void lidar_fields(LidarConfig& lidar, FieldCollector& v) {
  v("topic", lidar.topic, "cloud topic; auto: the only one, two or more are an error");
  v.custom("model",
           known_word(lidar.cloud.model, "auto, " + sensor::lidar_model_names(),
                      [](const std::string& name) {
                        return name == "auto" || sensor::find_lidar_model(name) != nullptr;
                      }),
           "sensor model, for ring angles and rebuilt point times");
  v.choice("point_time", lidar.cloud.point_time, wire::kPointTimeNames,
           "how point times are stored");
  v.choice("header_stamp", lidar.cloud.header_stamp, wire::kHeaderStampNames,
           "whether the stamp is the start or the end of the scan (with relative times)");
  v("deskewed", lidar.cloud.deskewed, "the driver has already undistorted the scans");
  v.choice("returns", lidar.returns, kReturnsNames,
           "which return of a pulse that has two: auto (one), strongest, last; single: all points");
  v("range_m", lidar.cloud.range_m, 0.0, 1000.0, "nearest and farthest point used [m]");
  v.custom("T_body_lidar", extrinsics_target(lidar.T_body_lidar, true),
           "pose of the LiDAR in the body; auto: /tf_static, the maker's figure, or the data");
  v.custom("time_offset_s", number_or(lidar.time_offset_s, "auto", -10.0, 10.0),
           "added to LiDAR stamps [s]; auto: estimated from turning, 0 if not certain");
}

void noise_fields(ImuNoiseConfig& noise, FieldCollector& v) {
  v.custom("accel_mps2_rthz", number_or(noise.accel_mps2_rthz, "auto", 1e-6, 10.0),
           "accelerometer white noise [m/s2/rtHz]; auto: of the model");
  v.custom("gyro_radps_rthz", number_or(noise.gyro_radps_rthz, "auto", 1e-7, 1.0),
           "gyro white noise [rad/s/rtHz]; auto: of the model");
  v.custom("accel_walk_mps3_rthz", number_or(noise.accel_walk_mps3_rthz, "auto", 0.0, 10.0),
           "accelerometer bias walk [m/s3/rtHz]");
  v.custom("gyro_walk_radps2_rthz", number_or(noise.gyro_walk_radps2_rthz, "auto", 0.0, 1.0),
           "gyro bias walk [rad/s2/rtHz]");
}

void imu_fields(ImuConfig& imu, const std::string& prefix, const std::string& base_dir,
                FieldList& fields) {
  FieldCollector v(prefix, fields);
  v("topic", imu.topic, "IMU topic; auto: the only one, none: LiDAR alone");
  v.custom("file", path_or_none(imu.file, base_dir), "CSV of inertial data beside a scan folder");
  const std::vector<std::string> names = imu_model_names();
  v.custom("model",
           known_word(imu.model, fmt::format("{}", fmt::join(names, ", ")),
                      [names](const std::string& name) {
                        return std::find(names.begin(), names.end(), name) != names.end();
                      }),
           "data sheet that the noise is taken from");
  v.choice("accel_unit", imu.accel_unit, kAccelUnitNames,
           "unit of accelerations; auto: by their value at standstill");
  v.choice("gyro_unit", imu.gyro_unit, kGyroUnitNames, "unit of turn rates; auto: by their value");
  FieldCollector noise(prefix + "noise.", fields);
  noise_fields(imu.noise, noise);
  v.custom("vibration_factor", number_or(imu.vibration_factor, "auto", 1.0, 100.0),
           "noise while driving / noise at standstill; auto: 3");
  v.custom("T_body_imu", extrinsics_target(imu.T_body_imu, true),
           "pose of the IMU in the body; body = IMU unless given; auto: base_link of /tf_static");
}

void vehicle_live_fields(VehicleLiveConfig& live, const std::string& prefix, FieldList& fields) {
  FieldCollector v(prefix + "live.", fields);
  v.custom("address", text_or_none(live.address), "of the vehicle on the fleet's network");
  v.custom("serial_port", text_or_none(live.serial_port), "device of the LinkTrack radio");
  v("serial_baud", live.serial_baud, 9600, 3000000, "speed of that port [Bd]");
}

void vehicle_fields(VehicleConfig& vehicle, const std::string& prefix, const std::string& base_dir,
                    FieldList& fields) {
  FieldCollector v(prefix, fields);
  v.custom("recording", path_list(vehicle.recordings, base_dir),
           "files read in order, or a folder; relative to this file");
  v("start_s", vehicle.start_s, 0.0, kWeek_s, "data left out at the start [s]");
  v("duration_s", vehicle.duration_s, 0.0, kWeek_s, "data used [s]; 0: all");
  v.custom("clock_offset_s", number_or(vehicle.clock_offset_s, "auto", -kWeek_s, kWeek_s),
           "added to all stamps of the vehicle [s]; auto: 0, or found with clock: offset");
  FieldCollector lidar(prefix + "lidar.", fields);
  lidar_fields(vehicle.lidar, lidar);
  imu_fields(vehicle.imu, prefix + "imu.", base_dir, fields);
  v.custom("antennas", antennas_target(vehicle.antennas), "radio antennas in the body [m]");
  v.custom("self_box_m", box_or_none(vehicle.self_box_m),
           "box around the own structure, in the body: points inside are left out [m]");
  vehicle_live_fields(vehicle.live, prefix, fields);
}

void range_fields(RangesConfig& ranges, const std::string& base_dir, FieldList& fields) {
  FieldCollector v("ranges.", fields);
  v.custom("sources", range_sources_target(ranges.sources, base_dir),
           "files, topics or logs with ranges");
  v.choice("stamp", ranges.stamp, kStampSourceNames, "clock of the stamps of ranges");
  v.custom("latency_s", number_or(ranges.latency_s, "auto", -5.0, 5.0),
           "age of a range at its stamp [s]; auto: from motion");
  v("sigma_m", ranges.sigma_m, 1e-3, 10.0, "noise of one range, 1 sigma [m]");
  v.custom("bias_m", range_bias_target(ranges), "constant error per pair [m]");
  v("limits_m", ranges.limits_m, 0.0, 10000.0, "shortest and longest range used [m]");
}

/// The map's voxel and grid are stored in the settings of module map, but their keys are here.
void output_fields(OutputConfig& output, map::MapSettings& map, const std::string& base_dir,
                   FieldList& fields) {
  FieldCollector v("output.", fields);
  v.choice("frame", output.frame, kOutputFrameNames, "whose pose the trajectories give");
  v("map_voxel_m", map.voxel_m, 0.0, 10.0, "one map point per cube; 0 keeps all [m]");
  FieldCollector grid("output.grid.", fields);
  grid("cell_m", map.grid.cell_m, 0.01, 1.0, "side of a cell of the 2-D grid [m]");
  grid("z_m", map.grid.z_m, -10.0, 50.0, "band above ground that is an obstacle [m]");
  v.custom("georeference", path_or_none(output.georeference, base_dir),
           "CSV of marks with known coordinates");
}

void live_fields(LiveConfig& live, const std::string& base_dir, FieldList& fields) {
  FieldCollector v("live.", fields);
  v("ros_domain", live.ros_domain, 0, 232, "ROS_DOMAIN_ID of sensors and outputs");
  v("ros_interface", live.ros_interface, "network of the ROS domain: name or address");
  v("fleet_domain", live.fleet_domain, 0, 229, "DDS domain between the vehicles");
  v.custom("key_file", path_or_none(live.key_file, base_dir),
           "key of the fleet; every message of a vehicle is authenticated with it");
  v("view_bind", live.view_bind, "address at which the live page is served");
  v("view_port", live.view_port, 0, 65535, "its port; 0: any");
  v.custom("view_token_file", path_or_none(live.view_token_file, base_dir),
           "word that viewers need where view_bind is not loopback");
}

CustomTarget rounds_target(std::string& rounds, const std::string& base_dir) {
  CustomTarget target;
  target.type = "auto, off, or a CSV file";
  target.decode = [&rounds, base_dir, type = target.type](const Node& node,
                                                          const std::string& key) -> Status {
    if (node.kind != Node::Kind::kScalar || node.text.empty()) return not_allowed(node, key, type);
    const bool word = node.text == "auto" || node.text == "off";
    rounds = word ? node.text : resolve_path(node.text, base_dir);
    return {};
  };
  target.encode = [&rounds, base_dir] {
    const bool word = rounds == "auto" || rounds == "off";
    return word ? rounds : yaml_quoted(relative_path(rounds, base_dir));
  };
  return target;
}

CustomTarget schema_target(int& schema) {
  CustomTarget target;
  target.type = "1";
  target.decode = [&schema](const Node& node, const std::string& /*key*/) -> Status {
    if (node.kind == Node::Kind::kScalar && node.text == "1") {
      schema = 1;
      return {};
    }
    return fail(ErrorCode::kUsage, node.where, fmt::format("schema {}", describe_value(node)),
                "This program reads schema 1 only.");
  };
  target.encode = [&schema] { return fmt::format("{}", schema); };
  return target;
}

}  // namespace

FieldList fleet_fields(FleetConfig& config, const std::string& base_dir) {
  FieldList fields;
  FieldCollector v("", fields);
  v.custom("schema", schema_target(config.schema), "version of this file's form");
  v.custom("preset", known_word(config.preset, preset_names_text(), is_preset),
           "robust: the default; paper: the method of the paper as published");
  for (VehicleConfig& vehicle : config.vehicles) {
    vehicle_fields(vehicle, "vehicles." + vehicle.name + '.', base_dir, fields);
  }
  range_fields(config.ranges, base_dir, fields);
  FieldCollector radio("radio.", fields);
  radio.custom("file", path_or_none(config.radio_file, base_dir),
               "CSV of signal strengths, for the end of rounds");
  v.choice("clock", config.clock, kClockNames,
           "clocks of the vehicles: synchronised; offset: one offset per vehicle; separate: "
           "recorded on other days");
  v.custom("priors", priors_target(config.priors),
           "known start poses of vehicles relative to each other");
  v.custom("rounds", rounds_target(config.rounds, base_dir),
           "which vehicle was the anchor at standstill, and when");
  output_fields(config.output, config.settings.map, base_dir, fields);
  live_fields(config.live, base_dir, fields);
  collect_fields("settings.", config.settings, fields);
  // One key per value: these are named under output:, under ranges: and under each vehicle's imu:.
  std::erase_if(fields, [](const Field& field) {
    return field.key == "settings.map.voxel_m" || field.key == "settings.map.grid.cell_m" ||
           field.key == "settings.map.grid.z_m" || field.key == "settings.ranging.limits.near_m" ||
           field.key == "settings.ranging.limits.far_m" ||
           field.key == "settings.ranging.limits.sigma_m" ||
           field.key.find("settings.odometry.imu_noise.") == 0;
  });
  for (Field& field : fields) {
    if (is_public_setting(field.key)) field.visibility = Visibility::kPublic;
  }
  return fields;
}

}  // namespace rali::config
