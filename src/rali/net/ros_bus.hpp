#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"

namespace rali::net {

/// How a topic is carried; names as in ROS 2.
struct RosQos {
  bool reliable = true;
  bool transient_local = false;  ///< who subscribes later gets the last ones
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
  Time t;  ///< of arrival, by the clock of this machine (UTC, as stamps of sensors have it)
  /// With the four bytes of the encapsulation header; up to three bytes of padding may follow.
  std::vector<std::uint8_t> cdr;
};

/// What happened on a bus since it was opened.
struct RosCounts {
  std::uint64_t published = 0;
  std::uint64_t refused = 0;  ///< not sent: too large, or a slow reliable reader had not taken more
  std::uint64_t arrived = 0, arrived_bytes = 0;
  std::uint64_t overflowed = 0;  ///< arrived, but pushed out by newer ones before take()
  std::uint64_t malformed = 0;   ///< too large, or without an encapsulation header that is known
};

/// Messages as ROS 2 knows them, on the vehicle's own network, without ROS: bytes in CDR with
/// their encapsulation header. One thread advertises, subscribes and publishes; another may take.
class RosBus {
 public:
  virtual ~RosBus() = default;

  /// @return number for publish(). Errors: kInput (not a ROS name), kMachine (no memory)
  [[nodiscard]] virtual Result<int> advertise(const RosTopic& topic) = 0;

  /// Never waits; what a slow reliable reader has not taken is dropped and counted.
  virtual void publish(int publication, std::span<const std::uint8_t> cdr) = 0;

  /// @return number in RosMessage::subscription
  [[nodiscard]] virtual Result<int> subscribe(const RosTopic& topic) = 0;

  /// What has arrived since the last call, per subscription in order; waits at most `timeout` for
  /// the first.
  [[nodiscard]] virtual std::vector<RosMessage> take(Duration timeout) = 0;

  /// Topics that others publish now, by name; one name may stand there with two types.
  [[nodiscard]] virtual std::vector<RosTopic> published() const = 0;

  /// Readers that match a publication now.
  [[nodiscard]] virtual int readers(int publication) const = 0;

  [[nodiscard]] virtual RosCounts counts() const { return {}; }
};

}  // namespace rali::net
