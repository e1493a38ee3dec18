#include "rali/jobs/range_job.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "rali/drive/ranges/start_prior.hpp"
#include "rali/jobs/input_checks.hpp"

namespace rali::jobs {
namespace {

using config::FleetConfig;
using config::VehicleConfig;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

static_assert(static_cast<int>(config::StampSource::kDevice) ==
              static_cast<int>(drive::RangeStamp::kDevice));
static_assert(static_cast<int>(config::StampSource::kRecord) ==
              static_cast<int>(drive::RangeStamp::kRecord));

/// A vehicle without antennas in the settings has one at its body origin.
std::vector<geometry::Vec3> antennas_of(const VehicleConfig& vehicle) {
  std::vector<geometry::Vec3> antennas;
  for (const config::AntennaConfig& antenna : vehicle.antennas) {
    antennas.push_back(antenna.p_body_m);
  }
  if (antennas.empty()) antennas.push_back(geometry::Vec3::Zero());
  return antennas;
}

io::RadioNames radio_names(const FleetConfig& fleet) {
  io::RadioNames names;
  for (std::size_t i = 0; i < fleet.vehicles.size(); ++i) {
    const VehicleConfig& vehicle = fleet.vehicles[i];
    const VehicleId id{static_cast<std::uint16_t>(i)};
    names[vehicle.name] = {id, 0};
    for (std::size_t a = 0; a < vehicle.antennas.size() && a <= 0xff; ++a) {
      names[vehicle.name + '/' + vehicle.antennas[a].name] = {id, static_cast<std::uint8_t>(a)};
    }
  }
  return names;
}

/// Names are checked by config::check_fleet; an unknown name stays a radio of nobody.
drive::RangeTopic range_topic(const config::RangeSource& source, const io::RadioNames& names) {
  drive::RangeTopic topic;
  topic.topic = source.topic;
  for (const auto& [number, radio] : source.ids) {
    const std::string name =
        radio.antenna.empty() ? radio.vehicle : radio.vehicle + '/' + radio.antenna;
    const auto found = names.find(name);
    if (found != names.end()) topic.ids[number] = found->second;
  }
  return topic;
}

/// A file is on the clock of the vehicle that wrote it: the first, unless stated otherwise.
VehicleId clock_of(const config::RangeSource& source, const io::RadioNames& names) {
  const auto named = names.find(source.vehicle);
  return named == names.end() ? VehicleId{} : named->second.vehicle;
}

std::optional<double> bias_between(const config::RangesConfig& ranges, const std::string& a,
                                   const std::string& b) {
  for (const std::string& pair : {a + '-' + b, b + '-' + a}) {
    const auto found = ranges.pair_bias_m.find(pair);
    if (found != ranges.pair_bias_m.end()) return found->second;
  }
  return ranges.bias_m;
}

}  // namespace

Result<drive::RangeOptions> range_options(const FleetConfig& fleet) {
  drive::RangeOptions options;
  options.names = radio_names(fleet);
  for (const VehicleConfig& vehicle : fleet.vehicles) {
    options.antennas.push_back(antennas_of(vehicle).size());
  }
  for (const config::RangeSource& source : fleet.ranges.sources) {
    if (!source.serial_log.empty()) {
      const auto vehicle = options.names.find(source.vehicle);
      if (vehicle == options.names.end()) {
        return fail(
            ErrorCode::kUsage, origin_of(fleet, "ranges.sources"),
            fmt::format("{}: a serial_log needs the vehicle of its radio", source.serial_log),
            "Add vehicle: NAME, one of those under `vehicles`.");
      }
      options.serial_logs.push_back(
          {source.serial_log, vehicle->second.vehicle, range_topic(source, options.names).ids});
    }
    if (!source.file.empty())
      options.files.push_back({source.file, clock_of(source, options.names)});
    if (!source.topic.empty()) options.topics.push_back(range_topic(source, options.names));
  }
  options.stamp = static_cast<drive::RangeStamp>(fleet.ranges.stamp);
  options.latency_s = fleet.ranges.latency_s;
  options.limits_m = fleet.ranges.limits_m;
  options.arrival = fleet.settings.ranging.arrival;
  options.exchange = fleet.settings.ranging.exchange;
  return options;
}

void set_ranging(const FleetConfig& fleet, std::size_t index, vehicle::VehicleSettings& settings) {
  const VehicleConfig& self = fleet.vehicles[index];
  const VehicleId own{static_cast<std::uint16_t>(index)};
  settings.antennas_body_m = antennas_of(self);
  settings.ranging = fleet.settings.ranging;
  settings.ranging.limits.sigma_m = fleet.ranges.sigma_m;
  settings.ranging.limits.near_m = fleet.ranges.limits_m[0];
  settings.ranging.limits.far_m = fleet.ranges.limits_m[1];
  settings.peers.clear();
  const std::vector<fleet::GivenStart> starts = fleet_knowledge(fleet).starts;
  for (std::size_t i = 0; i < fleet.vehicles.size(); ++i) {
    if (i == index) continue;
    vehicle::PeerSettings peer;
    peer.id = VehicleId{static_cast<std::uint16_t>(i)};
    peer.name = fleet.vehicles[i].name;
    peer.antennas_body_m = antennas_of(fleet.vehicles[i]);
    peer.prior = drive::prior_between(starts, own, peer.id);
    peer.bias_m = bias_between(fleet.ranges, self.name, peer.name);
    settings.peers.push_back(std::move(peer));
  }
}

fleet::FleetKnowledge fleet_knowledge(const FleetConfig& config) {
  const auto id_of = [&](const std::string& name) {
    std::size_t i = 0;
    while (i < config.vehicles.size() && config.vehicles[i].name != name) ++i;
    return VehicleId{static_cast<std::uint16_t>(i)};
  };
  fleet::FleetKnowledge known;
  known.common_clock = config.clock != config::Clock::kSeparate;
  for (const config::PriorConfig& prior : config.priors) {
    fleet::GivenStart start;
    start.relative_to =
        id_of(prior.relative_to.empty() ? config.vehicles.front().name : prior.relative_to);
    start.vehicle = id_of(prior.vehicle);
    start.T_relative_vehicle.R = geometry::rotation_from_rpy(0.0, 0.0, prior.yaw_deg * kRadPerDeg);
    start.T_relative_vehicle.p = prior.p_m;
    start.sigma_m = prior.sigma_m;
    start.sigma_rad = prior.sigma_deg * kRadPerDeg;
    known.starts.push_back(start);
  }
  for (std::size_t b = 0; b < config.vehicles.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const std::optional<double> bias_m =
          bias_between(config.ranges, config.vehicles[a].name, config.vehicles[b].name);
      if (!bias_m) continue;
      known.biases.push_back({VehicleId{static_cast<std::uint16_t>(a)},
                              VehicleId{static_cast<std::uint16_t>(b)}, *bias_m});
    }
  }
  return known;
}

}  // namespace rali::jobs
