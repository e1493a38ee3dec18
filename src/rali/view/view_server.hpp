#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"

namespace rali::view {

struct ViewOptions {
  std::string bind = "127.0.0.1";
  std::uint16_t port = 8765;           ///< 0: any free one
  std::string token;                   ///< required of clients if `bind` is not loopback
  std::size_t queue_bytes = 4u << 20;  ///< per viewer; beyond it only the newest of each channel is
                                       ///< kept
};

/// A channel of the Foxglove WebSocket protocol. The page uses the one named "/rali/state" (JSON).
struct ViewChannel {
  std::string topic;
  std::string encoding;         ///< "cdr" or "json"
  std::string schema_name;      ///< "nav_msgs/msg/Odometry"
  std::string schema_encoding;  ///< "ros2msg" or "jsonschema"
  std::string schema;
  bool keep_last = false;  ///< sent at once to late subscribers
};

/// An order of `rali operator`, authenticated by the token or from loopback.
struct OperatorRequest {
  std::string command;  ///< "end-round", "assume-lost", "finish"
  std::string vehicle;  ///< of assume-lost
};

/// One port for the live page, the Foxglove WebSocket, /healthz, /metrics and /operator. It has its
/// own thread; no call waits for a viewer. Calls from one thread at a time.
class ViewServer {
 public:
  virtual ~ViewServer() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;

  /// @return number for publish()
  [[nodiscard]] virtual int add_channel(const ViewChannel& channel) = 0;
  virtual void publish(int channel, Time t, std::span<const std::uint8_t> bytes) = 0;

  /// Sets the answer of /healthz: 200 if healthy, 503 otherwise.
  virtual void set_health(bool healthy, std::string json) = 0;

  /// Sets the answer of /metrics, Prometheus text.
  virtual void set_metrics(std::string text) = 0;

  /// Orders received since the last call.
  [[nodiscard]] virtual std::vector<OperatorRequest> take_requests() = 0;

  [[nodiscard]] virtual int viewers() const = 0;
};

/// Errors: kMachine (port in use: named, with a remedy), kInput (no token beyond loopback)
[[nodiscard]] Result<std::unique_ptr<ViewServer>> start_view_server(const ViewOptions& options);

}  // namespace rali::view
