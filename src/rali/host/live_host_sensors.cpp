#include <utility>

#include "rali/host/internal/live_host_impl.hpp"
#include "rali/net/wall_clock.hpp"

// The thread of sensors and odometry.
namespace rali::host {
namespace {

constexpr Duration kTakeWait = Duration::from_ns(5'000'000);
constexpr double kTopics_s = 0.5, kSensorNews_s = 0.2;

}  // namespace

Status LiveHost::Impl::advertise() {
  for (std::size_t i = 0; i < kRosTopics; ++i) {
    const Result<int> id = parts_.bus->advertise(ros_topic(static_cast<RosTopicId>(i), vehicle_));
    if (!id) return tl::make_unexpected(id.error());
    publications_[i] = *id;
  }
  const std::string status = "/" + ros_name(vehicle_) + "/navigate_to_pose/_action/status";
  const Result<int> id =
      parts_.bus->subscribe({status, std::string(wire::kGoalStatusType), {true, true, 1}});
  if (!id) return tl::make_unexpected(id.error());
  goal_status_ = *id;
  return {};
}

/// Unreadable messages are dropped: the state of a drive is also derived from the motion.
void LiveHost::Impl::take_goal_status(const net::RosMessage& message, std::vector<ToAgent>& news) {
  auto status = wire::decode_goal_status(as_message(message.cdr));
  if (status) news.emplace_back(GoalNews{std::move(*status)});
}

void LiveHost::Impl::publish(const RosOut& message) {
  parts_.bus->publish(publications_[static_cast<std::size_t>(message.topic)],
                      as_octets_of(message.cdr));
  if (viewers_.load(std::memory_order_relaxed) > 0) to_view_.put(message);
}

void LiveHost::Impl::send_news(std::vector<ToAgent>& news) {
  for (ToAgent& item : news) to_agent_.put(std::move(item));
  news.clear();
}

void LiveHost::Impl::keep_poses() {
  if (parts_.poses == nullptr) return;
  for (const io::StampedPose& pose : sensors_.map_poses()) to_poses_.put(pose);
}

void LiveHost::Impl::drain_outbox() {
  for (const RosOut& message : outbox_.take()) {
    parts_.bus->publish(publications_[static_cast<std::size_t>(message.topic)],
                        as_octets_of(message.cdr));
  }
}

void LiveHost::Impl::look_for_topics(HostTime now) {
  if (next_topics_ && now.boot < *next_topics_) return;
  next_topics_ = now.boot + Duration::from_s(kTopics_s);
  for (const net::RosTopic& topic : sensors_.intake().choose(parts_.bus->published(), now.boot)) {
    const Result<int> id = parts_.bus->subscribe(topic);
    if (id) {
      subscriptions_[*id] = topic;
    } else {
      findings_.put(finding_of("live.subscribe", Severity::kError, id.error().message(), ""));
    }
  }
}

void LiveHost::Impl::sensor_loop(const std::atomic<bool>& stop) {
  std::vector<ToAgent> news;
  const auto wall = [] { return net::wall_now(); };
  const Publish send = [this](const RosOut& message) { publish(message); };
  while (!stop.load(std::memory_order_relaxed)) {
    for (net::RosMessage& message : parts_.bus->take(kTakeWait)) {
      if (message.subscription == goal_status_) take_goal_status(message, news);
      const auto topic = subscriptions_.find(message.subscription);
      if (topic == subscriptions_.end()) continue;
      sensors_.intake().take(topic->second, message.t, as_message(message.cdr));
      if (parts_.record != nullptr) {
        to_record_.put({topic->second, message.t, std::move(message.cdr)});
      }
    }
    for (const net::SerialBytes& bytes : from_serial_.take()) {
      sensors_.intake().take_serial(bytes.t, bytes.bytes);
    }
    for (const ToSensors& item : to_sensors_.take()) sensors_.take(item);
    sensors_.run(wall, send, news);
    keep_poses();
    const HostTime now = host_now();
    look_for_topics(now);
    for (Finding& finding : sensors_.intake().take_findings()) findings_.put(std::move(finding));
    if (!next_sensor_news_ || now.boot >= *next_sensor_news_) {
      next_sensor_news_ = now.boot + Duration::from_s(kSensorNews_s);
      news.emplace_back(sensors_.sensor_news());
    }
    send_news(news);
    drain_outbox();
  }
  sensors_.finish(send, news);
  keep_poses();
  news.emplace_back(sensors_.sensor_news());
  send_news(news);
  drain_outbox();
}

}  // namespace rali::host
