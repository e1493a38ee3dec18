#include "rali/host/world/live_world.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <variant>

#include "rali/scenario/recording/fleet_yaml.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"

namespace rali::host {
namespace {

using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

// The profile of drivers of these sensors and of ROS 2 subscribers to sensor data.
constexpr net::RosQos kSensorQos{.reliable = false, .transient_local = false, .depth = 5};
// A LiDAR subscriber may miss a scan; one that waits for the next inertial sample may not.
constexpr net::RosQos kImuQos{.reliable = true, .transient_local = false, .depth = 400};
constexpr net::RosQos kStatusQos{.reliable = true, .transient_local = true, .depth = 1};

std::span<const std::byte> bytes_of(const net::RosMessage& message) {
  return std::as_bytes(std::span(message.cdr));
}

wire::GoalStatus::State state_of(sim::DriveStatus status) {
  switch (status) {
    case sim::DriveStatus::kStanding:
      return wire::GoalStatus::kCanceled;
    case sim::DriveStatus::kDriving:
      return wire::GoalStatus::kExecuting;
    case sim::DriveStatus::kArrived:
      return wire::GoalStatus::kSucceeded;
    case sim::DriveStatus::kUnreachable:
    case sim::DriveStatus::kBlocked:
      return wire::GoalStatus::kAborted;
  }
  return wire::GoalStatus::kUnknown;
}

/// A unique id for the n-th goal of this world.
std::array<std::uint8_t, 16> goal_id(std::uint64_t n) {
  std::array<std::uint8_t, 16> id{};
  for (std::size_t byte = 0; byte < 8; ++byte) {
    id[byte] = static_cast<std::uint8_t>((n >> (8 * byte)) & 0xffU);
  }
  return id;
}

}  // namespace

LiveWorld::LiveWorld(net::RosBus& bus, const LiveWorldOptions& options,
                     std::function<bool(Time)> wait)
    : bus_(bus), options_(options), wait_(std::move(wait)) {
  for (const std::string& name : options_.vehicles) vehicles_.emplace_back().name = name;
}

Result<std::unique_ptr<LiveWorld>> LiveWorld::make(net::RosBus& bus,
                                                   const LiveWorldOptions& options,
                                                   std::function<bool(Time)> wait) {
  std::unique_ptr<LiveWorld> world(new LiveWorld(bus, options, std::move(wait)));
  if (Status opened = world->open(); !opened) return tl::make_unexpected(opened.error());
  return world;
}

Status LiveWorld::open() {
  const Result<int> tf = bus_.subscribe({"/tf", "tf2_msgs/msg/TFMessage", {true, false, 100}});
  if (!tf) return tl::make_unexpected(tf.error());
  tf_ = *tf;
  for (Vehicle& vehicle : vehicles_) {
    if (Status s = open(vehicle); !s) return s;
  }
  return {};
}

Status LiveWorld::open(Vehicle& vehicle) {
  const auto topic = [&](std::string_view name) {
    return scenario::live_topic(vehicle.name, name);
  };
  const auto put = [](int& number, const Result<int>& made) -> Status {
    if (!made) return tl::make_unexpected(made.error());
    number = *made;
    return {};
  };
  const auto advertise = [&](int& number, std::string name, std::string_view type,
                             const net::RosQos& qos) {
    return put(number, bus_.advertise({std::move(name), std::string(type), qos}));
  };
  const auto subscribe = [&](int& number, std::string name, std::string_view type) {
    return put(number, bus_.subscribe({std::move(name), std::string(type), {}}));
  };
  Status s = advertise(vehicle.cloud, topic(scenario::driver_of(options_.lidar).topic),
                       "sensor_msgs/msg/PointCloud2", kSensorQos);
  if (s) s = advertise(vehicle.imu, topic(scenario::kImuTopic), "sensor_msgs/msg/Imu", kImuQos);
  if (s)
    s = advertise(vehicle.ranges, topic(scenario::kLiveRangeTopic), "rali_msgs/msg/Range", kImuQos);
  if (s) {
    s = advertise(vehicle.status, topic("navigate_to_pose/_action/status"), wire::kGoalStatusType,
                  kStatusQos);
  }
  if (s) s = subscribe(vehicle.goal, topic("goal_pose"), "geometry_msgs/msg/PoseStamped");
  if (s) s = subscribe(vehicle.odom, topic("odom"), "nav_msgs/msg/Odometry");
  return s;
}

void LiveWorld::publish(int publication, const wire::Bytes& bytes) {
  bus_.publish(publication, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

void LiveWorld::on_message(const sim::FleetMessage& message) {
  const Vehicle& vehicle = vehicles_.at(static_cast<std::size_t>(message.vehicle));
  if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
    publish(vehicle.imu, wire::encode(wire::ImuMessage{*imu, "imu"}, wire::Encoding::kCdr));
  } else if (const auto* scan = std::get_if<ScanPtr>(&message.data)) {
    send(**scan, vehicle);
  } else if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
    send(*range);
  }
  // The signal strength has no topic: a radio's own software measures it.
}

void LiveWorld::send(const sensor::LidarScan& scan, const Vehicle& vehicle) {
  const scenario::LidarDriver driver = scenario::driver_of(options_.lidar);
  const wire::PackedCloud cloud = wire::pack_cloud(scan, std::string(driver.frame), driver.style);
  publish(vehicle.cloud, wire::encode(cloud.view, wire::Encoding::kCdr));
}

/// Both radios of an exchange publish its range.
void LiveWorld::send(const sensor::RangeSample& range) {
  const std::size_t from = range.from.value, to = range.to.value;
  if (from >= vehicles_.size() || to >= vehicles_.size()) return;
  wire::RangeMessage message;
  message.stamp = range.t;
  message.from = vehicles_[from].name;
  message.to = vehicles_[to].name;
  message.range_m = range.range_m;
  message.rssi_dbm = static_cast<float>(range.rssi_dbm);
  message.rssi_first_path_dbm = static_cast<float>(range.first_path_dbm);
  for (const std::size_t end : {from, to}) {
    message.antenna = vehicles_[end].name + "/uwb";
    publish(vehicles_[end].ranges, wire::encode(message, wire::Encoding::kCdr));
  }
}

void LiveWorld::take_goal(Vehicle& vehicle, const net::RosMessage& message, Time now) {
  auto goal = wire::decode_pose_stamped(bytes_of(message), wire::Encoding::kCdr);
  if (!goal || goal->frame_id != "map" || !goal->T_frame_body.p.allFinite()) {
    ++counts_.unreadable;
    return;
  }
  ++counts_.goals;
  vehicle.waiting = std::move(*goal);
  // A new goal replaces the old one, and gets its own id when it arrives.
  wire::GoalStatus status;
  status.goal_id = goal_id(counts_.goals);
  status.accepted = now;
  status.state = wire::GoalStatus::kAccepted;
  vehicle.status_sent.goals = {status};
  publish(vehicle.status, wire::encode(vehicle.status_sent));
}

void LiveWorld::take_tf(const net::RosMessage& message) {
  const auto tf = wire::decode_tf(bytes_of(message), wire::Encoding::kCdr);
  if (!tf) {
    ++counts_.unreadable;
    return;
  }
  for (const wire::TransformStamped& t : tf->transforms) {
    if (t.frame_id != "map") continue;
    for (Vehicle& vehicle : vehicles_) {
      if (t.child_frame_id == vehicle.name + "/odom") vehicle.T_map_odom = t.T_frame_child;
    }
  }
}

void LiveWorld::take_odom(Vehicle& vehicle, const net::RosMessage& message) {
  const auto pose = wire::decode_odometry(bytes_of(message), wire::Encoding::kCdr);
  if (!pose) {
    ++counts_.unreadable;
    return;
  }
  vehicle.T_odom_body = pose->T_frame_child;
  vehicle.t_pose = pose->stamp;
}

void LiveWorld::take(Time now) {
  for (const net::RosMessage& message : bus_.take(Duration{})) {
    if (message.subscription == tf_) {
      take_tf(message);
      continue;
    }
    for (Vehicle& vehicle : vehicles_) {
      if (message.subscription == vehicle.goal) take_goal(vehicle, message, now);
      if (message.subscription == vehicle.odom) take_odom(vehicle, message);
    }
  }
}

/// A goal waits until the vehicle's pose in the map is known.
std::optional<sim::DriveCommand> LiveWorld::command(std::size_t index) {
  Vehicle& vehicle = vehicles_[index];
  if (!vehicle.waiting || !vehicle.T_map_odom || !vehicle.T_odom_body) return std::nullopt;
  sim::DriveCommand command;
  command.vehicle = static_cast<int>(index);
  command.places_map_m = {vehicle.waiting->T_frame_body.p};
  command.T_map_body = *vehicle.T_map_odom * *vehicle.T_odom_body;
  command.t = vehicle.t_pose;
  vehicle.waiting.reset();
  ++vehicle.goals;
  return command;
}

void LiveWorld::send_status(Vehicle& vehicle, const sim::DriveReport& report) {
  // A command takes effect after it was returned: until then the report is of the previous goal.
  if (vehicle.status_sent.goals.empty() || vehicle.waiting || report.goals < vehicle.goals) return;
  wire::GoalStatus& status = vehicle.status_sent.goals.front();
  const wire::GoalStatus::State state = state_of(report.status);
  if (status.state == state) return;
  status.state = state;
  publish(vehicle.status, wire::encode(vehicle.status_sent));
}

std::vector<std::string> LiveWorld::unsubscribed() const {
  std::vector<std::string> names;
  for (const Vehicle& vehicle : vehicles_) {
    if (bus_.readers(vehicle.cloud) == 0) names.push_back(vehicle.name);
  }
  return names;
}

std::vector<sim::DriveCommand> LiveWorld::decide(Time now,
                                                 std::span<const sim::DriveReport> reports) {
  std::vector<sim::DriveCommand> commands;
  for (std::size_t v = 0; v < vehicles_.size() && v < reports.size(); ++v) {
    send_status(vehicles_[v], reports[v]);
  }
  stopped_ = stopped_ || !wait_(now);
  take(now);
  for (std::size_t v = 0; v < vehicles_.size(); ++v) {
    if (auto made = command(v)) commands.push_back(std::move(*made));
  }
  return commands;
}

}  // namespace rali::host
