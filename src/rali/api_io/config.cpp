#include "rali/config.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/api/vehicle_settings.hpp"
#include "rali/api_io/fleet_config.hpp"
#include "rali/config/load_fleet.hpp"
#include "rali/jobs/load_inputs.hpp"
#include "rali/jobs/map_job.hpp"

namespace rali {
namespace {

config::Overrides overrides_of(const LoadOptions& options) {
  config::Overrides overrides{options.preset, {}};
  for (const auto& [key, value] : options.settings) {
    overrides.assignments.push_back(fmt::format("{}={}", key, value));
  }
  return overrides;
}

/// In the library the settings come from the calling program, not from the command line.
[[noreturn]] void throw_config_error(Error error) {
  if (error.where == "command line") error.where = "settings";
  api::throw_error(error);
}

FleetConfig config_of(const Result<jobs::MapInputs>& inputs) {
  if (!inputs) throw_config_error(inputs.error());
  return FleetConfig(
      std::make_shared<const FleetConfig::Impl>(FleetConfig::Impl{inputs->fleet, inputs->facts}));
}

}  // namespace

namespace api_io {

VehicleOptions public_options(const vehicle::VehicleSettings& settings) {
  VehicleOptions options;
  options.name = settings.name;
  options.T_body_lidar = api::public_pose(settings.calibration.T_body_lidar);
  options.T_body_imu = api::public_pose(settings.calibration.T_body_imu);
  options.has_imu = settings.has_imu;
  const odometry::ImuNoiseSettings& noise = settings.odometry.imu_noise;
  options.imu_noise = {noise.accel_mps2_rthz, noise.gyro_radps_rthz, noise.accel_walk_mps3_rthz,
                       noise.gyro_walk_radps2_rthz, noise.vibration_factor};
  options.antennas_body_m = settings.antennas_body_m;
  for (const vehicle::PeerSettings& peer : settings.peers) {
    options.peers.push_back({peer.name, peer.antennas_body_m});
  }
  options.settings = VehicleSettings(
      std::make_shared<const VehicleSettings::Impl>(VehicleSettings::Impl{settings}));
  return options;
}

}  // namespace api_io

FleetConfig::FleetConfig(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

std::vector<std::string> FleetConfig::vehicles() const {
  std::vector<std::string> names;
  for (const config::VehicleConfig& vehicle : impl_->fleet.vehicles) names.push_back(vehicle.name);
  return names;
}

std::string FleetConfig::yaml() const { return config::dump_fleet(impl_->fleet, ""); }

FleetConfig load_fleet(const std::string& path, const LoadOptions& options) {
  return config_of(
      config::load_fleet(path, overrides_of(options)).map([](config::FleetConfig fleet) {
        return jobs::MapInputs{std::move(fleet), nullptr};
      }));
}

FleetConfig load_inputs(const std::vector<std::string>& inputs, const LoadOptions& options) {
  if (inputs.empty()) {
    throw SettingsError("inputs", "there is no input", "Give recordings or one fleet.yaml.");
  }
  return config_of(jobs::load_inputs(inputs, overrides_of(options)));
}

VehicleOptions with_settings(VehicleOptions options, const LoadOptions& settings) {
  constexpr const char* kOneVehicle = "vehicles: {v1: {recording: none}}";
  const auto fleet = config::parse_fleet(kOneVehicle, "settings", "", overrides_of(settings));
  if (!fleet) throw_config_error(fleet.error());
  options.settings = api_io::public_options(jobs::vehicle_settings(*fleet, 0)).settings;
  return options;
}

}  // namespace rali
