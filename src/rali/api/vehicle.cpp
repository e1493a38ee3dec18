#include "rali/vehicle.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/api/vehicle_settings.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali {
namespace {

/// The vehicle itself has number 0, its peers follow in their order.
api::VehicleNames names_of(const VehicleOptions& options) {
  api::VehicleNames names{options.name};
  for (const Peer& peer : options.peers) {
    if (std::find(names.begin(), names.end(), peer.name) != names.end()) {
      throw SettingsError("peers", fmt::format("'{}' is there twice", peer.name),
                          "Give each vehicle a name of its own.");
    }
    if (peer.antennas_body_m.empty()) {
      throw SettingsError("peers." + peer.name, "has no antenna", "Give at least one position.");
    }
    names.push_back(peer.name);
  }
  return names;
}

vehicle::VehicleSettings inner_settings(const VehicleOptions& options) {
  vehicle::VehicleSettings settings = options.settings.impl().settings;
  settings.name = options.name;
  settings.has_imu = options.has_imu;
  settings.calibration.T_body_lidar = api::inner_pose(options.T_body_lidar);
  settings.calibration.T_body_imu = api::inner_pose(options.T_body_imu);
  odometry::ImuNoiseSettings& noise = settings.odometry.imu_noise;
  noise.accel_mps2_rthz = options.imu_noise.accel_mps2_rthz;
  noise.gyro_radps_rthz = options.imu_noise.gyro_radps_rthz;
  noise.accel_walk_mps3_rthz = options.imu_noise.accel_walk_mps3_rthz;
  noise.gyro_walk_radps2_rthz = options.imu_noise.gyro_walk_radps2_rthz;
  noise.vibration_factor = options.imu_noise.vibration_factor;
  settings.antennas_body_m = options.antennas_body_m;
  // A fleet.yaml's data on a peer (start pose, bias) are matched by its name.
  std::vector<vehicle::PeerSettings> known = std::move(settings.peers);
  settings.peers.clear();
  for (const Peer& peer : options.peers) {
    vehicle::PeerSettings& inner = settings.peers.emplace_back();
    const auto same = std::find_if(known.begin(), known.end(),
                                   [&](const auto& k) { return k.name == peer.name; });
    if (same != known.end()) inner = *same;
    inner.id = {static_cast<std::uint16_t>(settings.peers.size())};
    inner.name = peer.name;
    inner.antennas_body_m = peer.antennas_body_m;
  }
  return settings;
}

}  // namespace

VehicleSettings::VehicleSettings() : impl_(std::make_shared<const Impl>()) {}

VehicleSettings::VehicleSettings(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

struct Vehicle::Impl {
  explicit Impl(const VehicleOptions& options)
      : names(names_of(options)),
        range_m(options.range_m),
        vehicle(VehicleId{0}, inner_settings(options)) {}

  [[nodiscard]] VehicleId id_of(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      throw InputError(names.front(), fmt::format("'{}' is neither it nor a peer", name),
                       "Name all peers in VehicleOptions::peers.");
    }
    return {static_cast<std::uint16_t>(found - names.begin())};
  }

  [[nodiscard]] vehicle::Event inner(ImuSample sample) const {
    return sensor::ImuSample{Time::from_ns(sample.stamp_ns), sample.gyro_radps, sample.accel_mps2};
  }

  [[nodiscard]] vehicle::Event inner(Scan scan) const {
    return std::make_shared<const sensor::LidarScan>(
        api::value_or_throw(api::inner_scan(std::move(scan), range_m)));
  }

  [[nodiscard]] vehicle::Event inner(const RangeMeasurement& range) const {
    sensor::RangeSample sample;
    sample.t = Time::from_ns(range.stamp_ns);
    sample.from = id_of(range.from);
    sample.to = id_of(range.to);
    sample.from_antenna = range.from_antenna;
    sample.to_antenna = range.to_antenna;
    sample.range_m = range.range_m;
    sample.sigma_m = range.sigma_m;
    sample.rssi_dbm = range.rssi_dbm;
    sample.first_path_dbm = range.first_path_dbm;
    return sample;
  }

  [[nodiscard]] vehicle::Event inner(const PeerState& state) const {
    return vehicle::PeerStatus{id_of(state.vehicle), Time::from_ns(state.stamp_ns),
                               state.standstill};
  }

  [[nodiscard]] vehicle::Event inner(EndOfData) const { return vehicle::EndOfData{}; }

  [[nodiscard]] std::optional<Output> outer(const vehicle::Output& output) const {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      return api::public_estimate(*pose, names.front());
    }
    if (const auto* added = std::get_if<vehicle::KeyframeAdded>(&output)) {
      return api::public_keyframe(*added, names.front());
    }
    if (const auto* use = std::get_if<ranging::RangeUse>(&output)) {
      return api::public_range(*use, names);
    }
    if (const auto* finding = std::get_if<Finding>(&output)) {
      return api::public_finding(*finding, names.front());
    }
    return std::nullopt;  // messages between vehicles
  }

  api::VehicleNames names;
  std::array<double, 2> range_m;
  SerialExecutor executor;
  vehicle::Vehicle vehicle;
  vehicle::OutputList outputs;
};

Vehicle::Vehicle(const VehicleOptions& options) {
  if (options.antennas_body_m.empty()) {
    throw SettingsError("antennas_body_m", "is empty", "Give at least one position.");
  }
  impl_ = std::make_unique<Impl>(options);
}

Vehicle::~Vehicle() = default;
Vehicle::Vehicle(Vehicle&&) noexcept = default;
Vehicle& Vehicle::operator=(Vehicle&&) noexcept = default;

std::vector<Output> Vehicle::step(Event event) {
  const vehicle::Event inner =
      std::visit([&](auto& e) { return impl_->inner(std::move(e)); }, event);
  impl_->outputs.clear();
  impl_->vehicle.step(inner, impl_->executor, impl_->outputs);
  std::vector<Output> result;
  for (const vehicle::Output& output : impl_->outputs) {
    if (std::optional<Output> outer = impl_->outer(output)) result.push_back(std::move(*outer));
  }
  return result;
}

std::uint64_t Vehicle::state_hash() const { return impl_->vehicle.state_hash(); }

}  // namespace rali
