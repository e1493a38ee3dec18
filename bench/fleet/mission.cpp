#include "mission.hpp"

#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "common/cpu_time.hpp"
#include "common/option_hash.hpp"
#include "common/vehicle_settings.hpp"
#include "rali/drive/ranges/start_prior.hpp"
#include "rali/vehicle/vehicle.hpp"
#include "rali/wire/fleet/codec.hpp"
#include "starts.hpp"

namespace rali::fleet_bench {

namespace {

std::string vehicle_name(int vehicle) { return fmt::format("v{}", vehicle + 1); }

VehicleId id_of(int vehicle) { return VehicleId{static_cast<std::uint16_t>(vehicle)}; }

std::vector<geometry::Vec3> antennas_of(const sim::FleetSimulation& sim, int vehicle) {
  std::vector<geometry::Vec3> antennas;
  for (const sim::AntennaMount& mount : sim.antennas(vehicle)) {
    antennas.push_back(mount.p_nominal_m);
  }
  return antennas;
}

/// The part of the simulation that one vehicle's software receives.
struct Part {
  int source = 0;  ///< vehicle of the simulation
  Time begin, end;
};

std::vector<Part> parts_of(const sim::FleetSimulation& sim, const Place& place) {
  std::vector<Part> parts;
  if (place.halves) {
    const Duration alone =
        Duration::from_s(0.5 * (1.0 - place.common) * seconds_between(sim.t_start(), sim.t_end()));
    parts.push_back({0, sim.t_start(), sim.t_end() - alone});
    parts.push_back({0, sim.t_start() + alone, sim.t_end()});
    return parts;
  }
  for (int v = 0; v < sim.vehicles(); ++v) parts.push_back({v, sim.t_start(), sim.t_end()});
  return parts;
}

/// The software of all vehicles, and the messages between them.
class Fleet {
 public:
  Fleet(const sim::FleetSimulation& sim, std::vector<Part> parts,
        const vehicle::VehicleSettings& common, const std::vector<fleet::GivenStart>& starts)
      : parts_(std::move(parts)) {
    const int n = static_cast<int>(parts_.size());
    for (int v = 0; v < n; ++v) {
      const Part& part = parts_[static_cast<std::size_t>(v)];
      vehicle::VehicleSettings settings = common;
      settings.name = vehicle_name(v);
      settings.calibration = sim.calibration_nominal(part.source);
      settings.antennas_body_m = antennas_of(sim, part.source);
      for (int other = 0; other < sim.vehicles(); ++other) {
        if (other == v) continue;
        vehicle::PeerSettings peer;
        peer.id = id_of(other);
        peer.name = vehicle_name(other);
        peer.antennas_body_m = antennas_of(sim, other);
        peer.prior = drive::prior_between(starts, id_of(v), id_of(other));
        settings.peers.push_back(std::move(peer));
      }
      vehicles_.emplace_back(id_of(v), settings);
      Driven driven;
      driven.T_world_start = sim.truth(part.source, part.begin).state.T_world_body;
      driven.path_m = sim.path_m(part.source);
      mission_.vehicles.push_back(std::move(driven));
    }
    mission_.duration_s = seconds_between(sim.t_start(), sim.t_end());
  }

  void take(const sim::FleetSimulation& sim, const sim::FleetMessage& message) {
    if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
      step(range->from.value, *range);
      step(range->to.value, *range);
      return;
    }
    for (std::size_t v = 0; v < parts_.size(); ++v) {
      if (parts_[v].source == message.vehicle) take_own(sim, message, v);
    }
  }

  Result<Mission> finish() {
    for (std::size_t v = 0; v < vehicles_.size(); ++v) step(v, vehicle::EndOfData{});
    if (!encoded_) return tl::make_unexpected(encoded_.error());
    return std::move(mission_);
  }

 private:
  void take_own(const sim::FleetSimulation& sim, const sim::FleetMessage& message, std::size_t v) {
    const Part& part = parts_[v];
    const auto within = [&part](Time t) { return t >= part.begin && t <= part.end; };
    if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
      if (within(imu->t)) step(v, *imu);
    } else if (const auto* scan =
                   std::get_if<std::shared_ptr<const sensor::LidarScan>>(&message.data)) {
      if (!within((*scan)->t_start) || !within((*scan)->t_end)) return;
      mission_.vehicles[v].truth.push_back(
          {(*scan)->t_end, sim.truth(part.source, (*scan)->t_end).state.T_world_body});
      step(v, *scan);
    }
  }

  void step(std::size_t v, const vehicle::Event& event) {
    vehicle::OutputList out;
    const double begin = bench::cpu_ms();
    vehicles_[v].step(event, executor_, out);
    mission_.cpu_ms += bench::cpu_ms() - begin;
    for (const vehicle::Output& output : out) take_output(v, output);
    for (const vehicle::Output& output : out) {
      const auto* status = std::get_if<vehicle::PeerStatus>(&output);
      for (std::size_t other = 0; status != nullptr && other < vehicles_.size(); ++other) {
        if (other != v) step(other, *status);
      }
    }
  }

  void take_output(std::size_t v, const vehicle::Output& output) {
    Driven& driven = mission_.vehicles[v];
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      driven.poses.push_back(drive::pose_record(*pose));
    } else if (const auto* corrected = std::get_if<vehicle::KeyframeCorrected>(&output)) {
      driven.smoothed[corrected->id.seq] = *corrected;
    } else if (const auto* added = std::get_if<vehicle::KeyframeAdded>(&output)) {
      if (added->keyframe) take_keyframe(*added, driven);
    } else if (const auto* made = std::get_if<vehicle::FactMade>(&output)) {
      const fleet::Envelope envelope{made->fact->key.vehicle, std::nullopt,
                                     fleet::FactMessage{made->fact}};
      auto bytes = wire::encode_envelope(envelope);
      if (bytes) {
        driven.facts.push_back(std::move(*bytes));
      } else if (encoded_) {
        encoded_ = tl::make_unexpected(bytes.error());
      }
    }
  }

  static void take_keyframe(const vehicle::KeyframeAdded& added, Driven& driven) {
    const odometry::Keyframe& keyframe = *added.keyframe;
    drive::KeyframeRecord record;
    record.id = added.id;
    record.t = keyframe.t;
    record.T_local_body = keyframe.T_odom_body;
    record.covariance = keyframe.covariance;
    record.T_body_lidar = keyframe.T_body_lidar;
    record.points = keyframe.cloud.size();
    driven.keyframes.push_back(record);
    const odometry::KeyframeCloud& cloud = keyframe.cloud;
    driven.points.push_back({cloud.x_m, cloud.y_m, cloud.z_m, cloud.intensity, cloud.ring});
  }

  SerialExecutor executor_;
  std::vector<Part> parts_;
  std::vector<vehicle::Vehicle> vehicles_;
  Mission mission_;
  Status encoded_;
};

std::string file_name(const Place& place, const PlaceWorld& world) {
  bench::OptionHash hash;
  bench::add_options(world.options.vehicle, hash);
  hash.add(place.halves ? 2 : world.options.vehicles);
  hash.add(place.halves ? 1.0 + place.common : 0.0);
  if (place.known) hash.add(1.0);
  for (const std::string& text : place.settings) {
    for (const char c : text) hash.add(static_cast<double>(c));
  }
  for (const char c : world.scene) hash.add(static_cast<double>(c));
  return fmt::format("mission_{}_{}_{:016x}.facts", name_of(place), place.seed, hash.value());
}

Result<Mission> drive_anew(const Place& place, PlaceWorld world) {
  const auto settings = bench::vehicle_settings(place.settings);
  if (!settings) return tl::make_unexpected(settings.error());
  auto sim = sim::make_fleet_simulation(std::move(world.world), world.options);
  if (!sim) return tl::make_unexpected(sim.error());
  std::vector<geometry::SE3> T_world_start;
  for (int v = 0; place.known && v < (*sim)->vehicles(); ++v) {
    T_world_start.push_back((*sim)->truth(v, (*sim)->t_start()).state.T_world_body);
  }
  Fleet fleet(**sim, parts_of(**sim, place), *settings, starts_by_hand(T_world_start, place.seed));
  while (auto message = (*sim)->next()) fleet.take(**sim, *message);
  return fleet.finish();
}

}  // namespace

Result<Mission> drive_mission(const Place& place, const std::string& cache_dir) {
  auto world = world_of(place);
  if (!world) return tl::make_unexpected(world.error());
  std::string path;
  Mission mission;
  if (!cache_dir.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(cache_dir, ignored);
    path = cache_dir + "/" + file_name(place, *world);
    if (load_mission(path, mission)) return mission;
  }
  auto driven = drive_anew(place, std::move(*world));
  if (!driven || path.empty()) return driven;
  if (auto ok = save_mission(path, *driven); !ok) return tl::make_unexpected(ok.error());
  return driven;
}

}  // namespace rali::fleet_bench
