#include "rali/jobs/map_job.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "rali/config/imu_models.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/jobs/input_checks.hpp"
#include "rali/jobs/range_job.hpp"

namespace rali::jobs {
namespace {

using config::Extrinsics;
using config::FleetConfig;
using config::VehicleConfig;

// The enums correspond by order: the room drive has its own.
static_assert(static_cast<int>(config::AccelUnit::kG) == static_cast<int>(drive::AccelUnit::kG));
static_assert(static_cast<int>(config::Returns::kSingle) == static_cast<int>(wire::Returns::kAll));
static_assert(static_cast<int>(config::Returns::kLast) == static_cast<int>(wire::Returns::kLast));
static_assert(static_cast<int>(config::OutputFrame::kImu) ==
              static_cast<int>(drive::OutputPoint::kImu));
static_assert(static_cast<int>(config::GyroUnit::kDegps) ==
              static_cast<int>(drive::GyroUnit::kDegps));
static_assert(static_cast<int>(config::CheckAction::kOff) ==
              static_cast<int>(drive::ExtrinsicsCheck::kOff));

tl::unexpected<Error> cannot(const FleetConfig& fleet, const std::string& key,
                             const std::string& what, const std::string& remedy) {
  return fail(ErrorCode::kUsage, origin_of(fleet, key), fmt::format("{} {}", key, what), remedy);
}

/// The bounding box in the LiDAR's axes of the box given in the body.
std::array<double, 6> box_in_lidar(const std::array<double, 6>& box_body,
                                   const geometry::SE3& T_body_lidar) {
  const geometry::SE3 T_lidar_body = T_body_lidar.inverse();
  std::array<double, 6> box{};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const geometry::Vec3 p_body(box_body[corner & 1U], box_body[2 + ((corner >> 1U) & 1U)],
                                box_body[4 + ((corner >> 2U) & 1U)]);
    const geometry::Vec3 p_lidar = T_lidar_body * p_body;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = p_lidar[static_cast<Eigen::Index>(axis)];
      box[2 * axis] = corner == 0 ? value : std::min(box[2 * axis], value);
      box[2 * axis + 1] = corner == 0 ? value : std::max(box[2 * axis + 1], value);
    }
  }
  return box;
}

Status check_possible(const FleetConfig& fleet) {
  for (const VehicleConfig& vehicle : fleet.vehicles) {
    const std::string key = "vehicles." + vehicle.name;
    if (vehicle.self_box_m && vehicle.lidar.T_body_lidar.source != Extrinsics::Source::kGiven) {
      return cannot(fleet, key + ".self_box_m", "needs numbers in lidar.T_body_lidar",
                    "Give T_body_lidar, since the box is in the body.");
    }
  }
  return {};
}

/// The rows are read before any computation, so that an input error costs no run.
Result<drive::RoundsJob> rounds_job(const FleetConfig& fleet, const io::RadioNames& names) {
  drive::RoundsJob job;
  job.rounds = fleet.settings.mission.rounds;
  if (fleet.vehicles.size() < 2 || fleet.rounds == "off") {
    job.from = drive::RoundsFrom::kOff;
    return job;
  }
  if (fleet.rounds != "auto") {
    job.from = drive::RoundsFrom::kTable;
    Result<std::vector<fleet::Stand>> table = drive::read_rounds_csv(fleet.rounds, names);
    if (!table) return tl::make_unexpected(table.error());
    job.table = std::move(*table);
    return job;
  }
  if (fleet.radio_file.empty()) return job;
  const Status radio = drive::read_radio(fleet.radio_file, names, job);
  if (!radio) return tl::make_unexpected(radio.error());
  return job;
}

drive::InputOptions input_options(const FleetConfig& fleet, const VehicleConfig& vehicle) {
  drive::InputOptions input;
  input.vehicle = vehicle.name;
  input.lidar_topic = vehicle.lidar.topic;
  input.imu_topic = vehicle.imu.topic;
  input.cloud = vehicle.lidar.cloud;
  input.cloud.returns = static_cast<wire::Returns>(vehicle.lidar.returns);
  if (vehicle.self_box_m) {
    input.cloud.self_box_lidar_m = box_in_lidar(*vehicle.self_box_m, vehicle.lidar.T_body_lidar.T);
  }
  input.accel_unit = static_cast<drive::AccelUnit>(vehicle.imu.accel_unit);
  input.gyro_unit = static_cast<drive::GyroUnit>(vehicle.imu.gyro_unit);
  if (vehicle.lidar.T_body_lidar.source == Extrinsics::Source::kGiven) {
    input.T_body_lidar = vehicle.lidar.T_body_lidar.T;
  }
  input.lidar_tf_frame = vehicle.lidar.T_body_lidar.tf_frame;
  input.T_body_imu = vehicle.imu.T_body_imu.T;
  input.imu_from_tf = vehicle.imu.T_body_imu.source != Extrinsics::Source::kGiven;
  input.imu_tf_frame = vehicle.imu.T_body_imu.tf_frame;
  input.lidar_time_offset.value_s = vehicle.lidar.time_offset_s.value_or(0.0);
  input.clock_offset.value_s = vehicle.clock_offset_s.value_or(0.0);
  input.start_s = vehicle.start_s;
  input.duration_s = vehicle.duration_s;
  input.extrinsics = static_cast<drive::ExtrinsicsCheck>(fleet.settings.checks.extrinsics);
  return input;
}

drive::VehicleJob vehicle_job(const FleetConfig& fleet, std::size_t index,
                              const MapOptions& options) {
  const VehicleConfig& vehicle = fleet.vehicles[index];
  drive::VehicleJob job;
  job.inputs = vehicle.recordings;
  job.imu_file = vehicle.imu.file;
  job.input = input_options(fleet, vehicle);
  job.input.strict = options.strict;
  job.settings = vehicle_settings(fleet, index);
  job.find_time_offset = !vehicle.lidar.time_offset_s;
  job.clock_offset_given = vehicle.clock_offset_s.has_value();
  return job;
}

void note_found(FleetConfig& fleet, const VehicleConfig& vehicle, const std::string& key,
                const std::string& origin) {
  fleet.origins["vehicles." + vehicle.name + '.' + key] = origin;
}

/// Writes down the noise that was used, so that a later table of models does not change a rerun.
void fix_noise(FleetConfig& fleet, VehicleConfig& vehicle) {
  const odometry::ImuNoiseSettings used = config::imu_noise_of(vehicle.imu);
  const std::string origin = "imu model " + vehicle.imu.model;
  const auto fix = [&](const char* key, std::optional<double>& value, double number) {
    if (value) return;
    value = number;
    note_found(fleet, vehicle, key, origin);
  };
  config::ImuNoiseConfig& noise = vehicle.imu.noise;
  fix("imu.noise.accel_mps2_rthz", noise.accel_mps2_rthz, used.accel_mps2_rthz);
  fix("imu.noise.gyro_radps_rthz", noise.gyro_radps_rthz, used.gyro_radps_rthz);
  fix("imu.noise.accel_walk_mps3_rthz", noise.accel_walk_mps3_rthz, used.accel_walk_mps3_rthz);
  fix("imu.noise.gyro_walk_radps2_rthz", noise.gyro_walk_radps2_rthz, used.gyro_walk_radps2_rthz);
  fix("imu.vibration_factor", vehicle.imu.vibration_factor, used.vibration_factor);
}

}  // namespace

Result<drive::MapJob> make_map_job(const FleetConfig& fleet, const MapOptions& options) {
  if (Status status = check_possible(fleet); !status) return tl::make_unexpected(status.error());
  if (Status status = check_side_files(fleet); !status) return tl::make_unexpected(status.error());
  drive::MapJob job;
  Result<drive::RangeOptions> ranges = range_options(fleet);
  if (!ranges) return tl::make_unexpected(ranges.error());
  job.ranges = std::move(*ranges);
  for (std::size_t i = 0; i < fleet.vehicles.size(); ++i) {
    job.vehicles.push_back(vehicle_job(fleet, i, options));
  }
  job.fleet = fleet.settings.fleet;
  job.fleet.ranging = job.vehicles.front().settings.ranging;
  const bool asked = std::any_of(fleet.vehicles.begin() + 1, fleet.vehicles.end(),
                                 [](const VehicleConfig& v) { return !v.clock_offset_s; });
  job.find_clock_offsets = fleet.clock == config::Clock::kOffset && asked;
  job.known = fleet_knowledge(fleet);
  Result<drive::RoundsJob> rounds = rounds_job(fleet, job.ranges.names);
  if (!rounds) return tl::make_unexpected(rounds.error());
  job.rounds = std::move(*rounds);
  job.out_dir = options.out_dir;
  job.overwrite = options.overwrite;
  job.strict = options.strict;
  job.threads = options.threads;
  job.formats = options.formats;
  job.map = fleet.settings.map;
  job.imu_rate = options.imu_rate;
  job.point = static_cast<drive::OutputPoint>(fleet.output.frame);
  if (!fleet.output.georeference.empty()) {
    auto marks = drive::read_marks_csv(fleet.output.georeference, job.ranges.names);
    if (!marks) return tl::make_unexpected(marks.error());
    job.marks = std::move(*marks);
  }
  job.write_mcap = options.mcap;
  job.write_keyframes = options.keyframes;
  job.command_line = options.command_line;
  job.facts = options.facts;
  job.settings_text = [fleet,
                       dir = options.out_dir](const std::vector<drive::InputReport>& reports) {
    return config::dump_fleet(with_findings(fleet, reports), dir);
  };
  return job;
}

vehicle::VehicleSettings vehicle_settings(const FleetConfig& fleet, std::size_t index) {
  const VehicleConfig& vehicle = fleet.vehicles[index];
  vehicle::VehicleSettings settings = fleet.settings.vehicle;
  settings.name = vehicle.name;
  settings.odometry = fleet.settings.odometry;
  settings.odometry.imu_noise = config::imu_noise_of(vehicle.imu);
  settings.calibration.T_body_lidar = vehicle.lidar.T_body_lidar.T;
  settings.calibration.T_body_imu = vehicle.imu.T_body_imu.T;
  set_ranging(fleet, index, settings);
  settings.has_imu = vehicle.imu.topic != "none";
  return settings;
}

std::vector<std::string> idle_keys(const FleetConfig& fleet) {
  std::vector<std::string> idle;
  for (const auto& origin : fleet.origins) {
    const std::string& key = origin.first;
    const std::string room = key.substr(0, key.find('.'));
    const bool between = room == "ranges" || room == "priors" || room == "clock" ||
                         room == "radio" || room == "rounds" ||
                         key.find(".antennas") != std::string::npos;
    // Radio explains why a round ended, only for rounds that are determined from the data.
    const bool radio = room == "radio" && fleet.rounds != "auto";
    const bool no_use = radio || (between && fleet.vehicles.size() < 2);
    if (no_use && origin.second.find("settings.yaml") == std::string::npos) idle.push_back(key);
  }
  return idle;
}

FleetConfig with_findings(const FleetConfig& fleet,
                          const std::vector<drive::InputReport>& reports) {
  FleetConfig found = fleet;
  std::vector<std::optional<drive::RangeLatency>> latencies;
  for (const drive::InputReport& report : reports) latencies.push_back(report.range_latency);
  // It stays auto: the stamps were not changed, and the filters estimated the offset.
  if (const auto latency = drive::combined(latencies); latency && !found.ranges.latency_s) {
    found.origins["ranges.latency_s"] = "found: " + drive::latency_words(*latency) + ", by motion";
  }
  for (const drive::InputReport& report : reports) {
    const auto vehicle =
        std::find_if(found.vehicles.begin(), found.vehicles.end(),
                     [&](const VehicleConfig& v) { return v.name == report.vehicle; });
    if (vehicle == found.vehicles.end()) continue;
    fix_noise(found, *vehicle);
    if (vehicle->lidar.topic == "auto" && !report.lidar_topic.empty()) {
      vehicle->lidar.topic = report.lidar_topic;
      note_found(found, *vehicle, "lidar.topic", "found: the recording");
    }
    if (vehicle->imu.topic == "auto" && !report.imu_topic.empty()) {
      vehicle->imu.topic = report.imu_topic;
      note_found(found, *vehicle, "imu.topic", "found: the recording");
    }
    if (vehicle->lidar.T_body_lidar.source != Extrinsics::Source::kGiven) {
      vehicle->lidar.T_body_lidar = {Extrinsics::Source::kGiven, report.T_body_lidar, {}, {}};
      note_found(found, *vehicle, "lidar.T_body_lidar", "found: " + report.T_body_lidar_origin);
    }
    if (vehicle->imu.T_body_imu.source != Extrinsics::Source::kGiven) {
      vehicle->imu.T_body_imu = {Extrinsics::Source::kGiven, report.T_body_imu, {}, {}};
      note_found(found, *vehicle, "imu.T_body_imu", "found: " + report.T_body_imu_origin);
    }
    if (!vehicle->clock_offset_s && report.clock_offset.sigma_s) {
      vehicle->clock_offset_s = report.clock_offset.value_s;
      note_found(found, *vehicle, "clock_offset_s", "found: " + report.clock_offset.origin);
    }
    // A dry run has not estimated it: it stays auto.
    if (!vehicle->lidar.time_offset_s && !report.lidar_time_offset.origin.empty()) {
      vehicle->lidar.time_offset_s = report.lidar_time_offset.value_s;
      note_found(found, *vehicle, "lidar.time_offset_s",
                 "found: " + report.lidar_time_offset.origin);
    }
  }
  return found;
}

}  // namespace rali::jobs
