#include "rali/host/sensor_topics.hpp"

#include <algorithm>

#include "rali/host/ros_outputs.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::host {
namespace {

/// A scan is large: two wait while the odometry processes another one.
constexpr int kScanDepth = 8;
/// One second of a fast IMU.
constexpr int kSampleDepth = 1000;

/// Best-effort readers match all writers.
net::RosTopic listened(const net::RosTopic& topic, int depth) {
  net::RosTopic out = topic;
  out.qos = {false, false, depth};
  return out;
}

drive::TopicCount count_of(const net::RosTopic& topic) {
  drive::TopicCount count;
  count.name = topic.name;
  count.type = topic.type;
  count.kind = wire::message_kind(topic.type);
  return count;
}

const net::RosTopic* find_topic(std::span<const net::RosTopic> topics, const std::string& name,
                                bool cloud) {
  for (const net::RosTopic& topic : topics) {
    const wire::MessageKind kind = wire::message_kind(topic.type);
    const bool fits = cloud ? wire::is_cloud(kind) : kind == wire::MessageKind::kImu;
    if (topic.name == name && fits) return &topic;
  }
  return nullptr;
}

bool is_range(const net::RosTopic& topic) {
  const wire::MessageKind kind = wire::message_kind(topic.type);
  return kind == wire::MessageKind::kLinktrack || kind == wire::MessageKind::kRaliRange;
}

/// Topics that rali publishes itself, or that belong to another vehicle on the same network.
bool is_foreign(const std::string& topic, const std::string& vehicle,
                std::span<const std::string> fleet) {
  if (topic == "/map_cloud" || topic == "/ranges") return true;
  return std::any_of(fleet.begin(), fleet.end(), [&](const std::string& name) {
    const std::string prefix = '/' + ros_name(name) + '/';
    return topic == prefix + "map_delta" || (name != vehicle && topic.starts_with(prefix));
  });
}

}  // namespace

Result<SensorTopics> choose_sensors(std::span<const net::RosTopic> published,
                                    const drive::InputOptions& options,
                                    std::span<const std::string> fleet) {
  std::vector<net::RosTopic> topics;
  std::vector<drive::TopicCount> counts;
  for (const net::RosTopic& topic : published) {
    if (is_foreign(topic.name, options.vehicle, fleet)) continue;
    topics.push_back(topic);
    counts.push_back(count_of(topic));
  }
  const std::string where = "ROS domain";
  if (topics.empty()) {
    return fail(ErrorCode::kInput, where, "nobody publishes anything",
                "Start the drivers; compare ROS_DOMAIN_ID with live.ros_domain.");
  }
  const Result<drive::TopicChoice> choice = drive::choose_topics(counts, options, where);
  if (!choice) return tl::make_unexpected(choice.error());
  SensorTopics sensors;
  sensors.lidar = listened(*find_topic(topics, choice->lidar, true), kScanDepth);
  if (!choice->imu.empty()) {
    sensors.imu = listened(*find_topic(topics, choice->imu, false), kSampleDepth);
  } else if (options.imu_topic != "none") {
    return fail(ErrorCode::kInput, where, "nobody publishes sensor_msgs/Imu",
                "Start its driver, or write imu.topic: none.");
  }
  for (const net::RosTopic& topic : topics) {
    const bool is_static = wire::message_kind(topic.type) == wire::MessageKind::kTf &&
                           topic.name.ends_with("tf_static");
    if (!is_static) continue;
    sensors.transforms.push_back(topic);
    sensors.transforms.back().qos = {true, true, 100};
  }
  return sensors;
}

std::vector<net::RosTopic> range_topics(std::span<const net::RosTopic> published,
                                        const drive::RangeOptions& ranges,
                                        const std::string& vehicle,
                                        std::span<const std::string> fleet) {
  std::vector<net::RosTopic> found;
  for (const net::RosTopic& topic : published) {
    if (!is_range(topic)) continue;
    const bool named = ranges.topic_of(topic.name) != nullptr;
    const bool any = ranges.topics.empty() && !is_foreign(topic.name, vehicle, fleet);
    if (named || any) found.push_back(listened(topic, kSampleDepth));
  }
  return found;
}

}  // namespace rali::host
