#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"

namespace rali::net {

/// Quality of service of a topic; names as in ROS 2.
struct RosQos {
  bool reliable = true;
  bool transient_local = false;  ///< late subscribers get the last messages
  int depth = 10;
};

/// `name` and `type` as `ros2 topic list -t` shows them: "/v1/odom", "nav_msgs/msg/Odometry".
struct RosTopic {
  std::string name;
  std::string type;
  RosQos qos;
};

struct RosMessage {
  int subscription = 0;
  Time t;  ///< of arrival, by the clock of this machine (UTC, as sensor stamps)
  /// With the four bytes of the encapsulation header; up to three bytes of padding may follow.
  std::vector<std::uint8_t> cdr;
};

/// Counts since a bus was opened.
struct RosCounts {
  std::uint64_t published = 0;
  std::uint64_t refused = 0;  ///< not sent: too large, or a slow reliable reader was behind
  std::uint64_t arrived = 0, arrived_bytes = 0;
  std::uint64_t overflowed = 0;  ///< arrived, but pushed out by newer ones before take()
  std::uint64_t malformed = 0;   ///< too large, or with an unknown encapsulation header
};

/// ROS 2 messages on the vehicle's own network, without ROS libraries: bytes in CDR with their
/// encapsulation header. One thread advertises, subscribes and publishes; another may take.
class RosBus {
 public:
  virtual ~RosBus() = default;

  /// @return number for publish(). Errors: kInput (not a ROS name), kMachine (no memory)
  [[nodiscard]] virtual Result<int> advertise(const RosTopic& topic) = 0;

  /// Never waits; messages that a slow reliable reader cannot take are dropped and counted.
  virtual void publish(int publication, std::span<const std::uint8_t> cdr) = 0;

  /// @return number in RosMessage::subscription
  [[nodiscard]] virtual Result<int> subscribe(const RosTopic& topic) = 0;

  /// Messages that arrived since the last call, per subscription in order; waits at most `timeout`
  /// for the first.
  [[nodiscard]] virtual std::vector<RosMessage> take(Duration timeout) = 0;

  /// Topics that others publish now, by name; one name may appear with two types.
  [[nodiscard]] virtual std::vector<RosTopic> published() const = 0;

  /// Readers that match a publication now.
  [[nodiscard]] virtual int readers(int publication) const = 0;

  [[nodiscard]] virtual RosCounts counts() const { return {}; }
};

}  // namespace rali::net
