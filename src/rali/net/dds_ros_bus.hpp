#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "rali/base/result.hpp"
#include "rali/net/ros_bus.hpp"

namespace rali::net {

struct RosBusOptions {
  int domain = 0;  ///< ROS_DOMAIN_ID, 0 to 232
  /// Name ("eth0") or IPv4 address of the network interface; "lo" restricts it to this machine.
  std::string interface = "lo";
  std::string node_name = "rali";  ///< as `ros2 node list` shows it
  std::string node_namespace = "/";
  int gid_bytes = 16;  ///< in ros_discovery_info: 16 from Iron on, 24 in Humble
  std::size_t message_bytes_max = std::size_t{64} << 20;  ///< larger ones are dropped and counted
  std::string cyclone_config;  ///< XML of Cyclone DDS or file:// names, applied over ours
};

/// Cyclone DDS with any type by its name. Only the encapsulation header and the size of messages
/// are checked: a decoder must check the rest.
/// Errors: kUsage (an option out of its range), kMachine (no such interface, no port, no memory).
[[nodiscard]] Result<std::unique_ptr<RosBus>> open_dds_ros_bus(const RosBusOptions& options);

/// Number of a ROS domain. Errors: kUsage with `where` (not 0 to 232).
[[nodiscard]] Result<int> parse_ros_domain(const std::string& text, const std::string& where);

/// ROS_DOMAIN_ID of the environment, 0 if it is not set. Errors: kUsage (not a domain number).
[[nodiscard]] Result<int> ros_domain_of_environment();

}  // namespace rali::net
