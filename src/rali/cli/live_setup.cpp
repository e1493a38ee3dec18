#include "rali/cli/live_setup.hpp"

#include <algorithm>
#include <fstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/suggest.hpp"
#include "rali/jobs/map_job.hpp"
#include "rali/net/dds_fleet_link.hpp"
#include "rali/net/dds_ros_bus.hpp"

namespace rali::cli {
namespace {

/// Radio numbers of all sources of ranges.
std::map<std::int64_t, io::RadioEnd> radio_ids(const drive::RangeOptions& ranges,
                                               VehicleId vehicle) {
  for (const drive::SerialLog& log : ranges.serial_logs) {
    if (log.vehicle == vehicle && !log.ids.empty()) return log.ids;
  }
  for (const drive::RangeTopic& topic : ranges.topics) {
    if (!topic.ids.empty()) return topic.ids;
  }
  return ranges.serial_logs.empty() ? std::map<std::int64_t, io::RadioEnd>{}
                                    : ranges.serial_logs.front().ids;
}

std::string address_of(const config::FleetConfig& fleet, std::size_t index) {
  return fleet.vehicles[index].live.address;
}

}  // namespace

std::vector<VehicleId> vehicle_ids(const config::FleetConfig& fleet) {
  std::vector<VehicleId> ids;
  for (std::size_t i = 0; i < fleet.vehicles.size(); ++i) {
    ids.push_back({static_cast<std::uint16_t>(i)});
  }
  return ids;
}

Result<std::size_t> vehicle_index(const config::FleetConfig& fleet, const std::string& name) {
  std::vector<std::string> names;
  for (const config::VehicleConfig& vehicle : fleet.vehicles) names.push_back(vehicle.name);
  if (name.empty() && names.size() == 1) return std::size_t{0};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
  }
  if (name.empty()) {
    return fail(ErrorCode::kUsage, "--vehicle", "which vehicle is this?",
                fmt::format("Give one of {}.", fmt::join(names, ", ")));
  }
  return fail(ErrorCode::kUsage, "--vehicle", fmt::format("'{}' is no vehicle", name),
              fmt::format("There is {}.", fmt::join(names, ", ")));
}

Result<LiveSetup> make_live_setup(const config::FleetConfig& fleet, std::size_t index) {
  config::FleetConfig live = fleet;
  // Files of recordings are not used live.
  std::erase_if(live.ranges.sources, [](const config::RangeSource& s) { return !s.file.empty(); });
  live.radio_file.clear();
  live.rounds = "auto";
  live.output.georeference.clear();
  Result<drive::MapJob> job = jobs::make_map_job(live, {});
  if (!job) return tl::make_unexpected(job.error());
  const VehicleId self{static_cast<std::uint16_t>(index)};
  const drive::VehicleJob& own = job->vehicles[index];

  LiveSetup setup;
  setup.index = index;
  host::SensorSideSetup& sensors = setup.host.sensors;
  sensors.self = self;
  sensors.vehicle = own.settings;
  sensors.intake.input = own.input;
  sensors.intake.input.self = self;
  sensors.intake.ranges = job->ranges;
  // As in ROS, a relative name is in the namespace of its vehicle: one line serves all vehicles.
  for (drive::RangeTopic& topic : sensors.intake.ranges.topics) {
    if (topic.topic.starts_with('/')) continue;
    topic.topic = fmt::format("/{}/{}", host::ros_name(own.settings.name), topic.topic);
  }
  sensors.intake.ranges.serial_logs = {
      {fleet.vehicles[index].live.serial_port, self, radio_ids(job->ranges, self)}};
  sensors.intake.order.has_imu = own.input.imu_topic != "none";

  host::AgentSetup& agent = setup.host.fleet.agent;
  agent.self = self;
  for (const drive::VehicleJob& vehicle : job->vehicles) {
    agent.names.push_back(vehicle.settings.name);
  }
  sensors.intake.fleet = agent.names;
  agent.node = live.settings.mission;
  agent.node.take(job->fleet);
  agent.known = job->known;
  setup.host.fleet.grid = live.settings.mission.explore;
  return setup;
}

void restore(LiveSetup& setup, drive::StateDir& state) {
  setup.host.epoch = state.epoch();
  setup.host.sensors.vehicle.facts.epoch = state.epoch();
  setup.host.fleet.agent.start = state.take_start();
}

Result<std::unique_ptr<net::RosBus>> open_ros_bus(const config::FleetConfig& fleet,
                                                  std::size_t index) {
  net::RosBusOptions options;
  options.domain = fleet.live.ros_domain;
  options.interface = fleet.live.ros_interface;
  options.node_name = "rali";
  options.node_namespace = '/' + host::ros_name(fleet.vehicles[index].name);
  return net::open_dds_ros_bus(options);
}

namespace {

/// The newest epoch of the facts of a vehicle, as far as known here.
std::uint32_t newest_epoch(const std::vector<fleet::FactPtr>& facts, VehicleId vehicle) {
  std::uint32_t newest = 0;
  for (const fleet::FactPtr& fact : facts) {
    if (fact->key.vehicle == vehicle) newest = std::max(newest, fact->key.epoch);
  }
  return newest;
}

}  // namespace

Result<std::unique_ptr<net::FleetLink>> open_fleet_link(const config::FleetConfig& fleet,
                                                        std::size_t index,
                                                        const fleet::NodeStart& start,
                                                        std::span<const std::byte> seen) {
  if (fleet.vehicles.size() < 2) return std::unique_ptr<net::FleetLink>();
  if (fleet.live.key_file.empty()) {
    return fail(ErrorCode::kUsage, "live.key_file", "a fleet needs a key",
                "Make one with `rali run --new-key FILE` and give it to all vehicles.");
  }
  Result<net::FleetKey> key = net::load_fleet_key(fleet.live.key_file);
  if (!key) return tl::make_unexpected(key.error());
  net::FleetLinkOptions options;
  options.self = {static_cast<std::uint16_t>(index)};
  options.epoch = start.epoch;
  options.domain = fleet.live.fleet_domain;
  options.key = *key;
  options.seen = net::decode_seen(seen).value_or(std::vector<net::SeenCounter>{});
  for (std::size_t i = 0; i < fleet.vehicles.size(); ++i) {
    const std::string address = address_of(fleet, i);
    if (address.empty()) {
      return fail(ErrorCode::kUsage,
                  fmt::format("vehicles.{}.live.address", fleet.vehicles[i].name), "is not given",
                  "All vehicles of a fleet need one.");
    }
    if (i == index) {
      options.address = address;
    } else {
      const VehicleId peer{static_cast<std::uint16_t>(i)};
      options.peers.push_back({peer, address, newest_epoch(start.facts, peer)});
    }
  }
  return net::open_dds_fleet_link(options);
}

Result<std::string> read_token(const std::string& path) {
  if (path.empty()) return std::string();
  std::ifstream file(path);
  std::string token;
  if (!(file >> token)) {
    return fail(ErrorCode::kInput, path, "holds no word", "Write one line with a secret word.");
  }
  return token;
}

}  // namespace rali::cli
