#include "rali/host/view_outputs.hpp"

#include <span>

#include "rali/wire/definitions.hpp"

namespace rali::host {
namespace {

std::span<const std::uint8_t> as_octets(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

std::span<const std::uint8_t> as_octets(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

view::ViewChannel json_channel(std::string topic, std::string schema_name) {
  return {std::move(topic),       "json", std::move(schema_name), "jsonschema",
          R"({"type":"object"})", true};
}

}  // namespace

ViewOutputs::ViewOutputs(view::ViewServer& server, const std::string& vehicle) : server_(server) {
  for (std::size_t i = 0; i < kRosTopics; ++i) {
    const net::RosTopic topic = ros_topic(static_cast<RosTopicId>(i), vehicle);
    channels_[i] = server_.add_channel({topic.name, "cdr", topic.type, "ros2msg",
                                        wire::message_definition(topic.type, wire::Encoding::kCdr),
                                        topic.qos.transient_local});
  }
  state_ = server_.add_channel(json_channel("/rali/state", "rali/State"));
  paths_ = server_.add_channel(json_channel("/rali/paths", "rali/Paths"));
}

void ViewOutputs::publish(const RosOut& message) {
  server_.publish(channels_[static_cast<std::size_t>(message.topic)], message.t,
                  as_octets(message.cdr));
}

void ViewOutputs::publish_paths(Time t, const std::string& json) {
  server_.publish(paths_, t, as_octets(json));
}

void ViewOutputs::publish(const LiveState& state) {
  server_.publish(state_, Time::from_s(state.t_s), as_octets(state_json(state)));
  std::string health;
  const bool healthy = health_json(state, health);
  server_.set_health(healthy, std::move(health));
  server_.set_metrics(metrics_text(state));
}

}  // namespace rali::host
