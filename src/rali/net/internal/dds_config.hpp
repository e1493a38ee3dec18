#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rali/net/dds_fleet_link.hpp"
#include "rali/net/dds_ros_bus.hpp"

/// Settings of Cyclone DDS as the text for dds_create_domain.
namespace rali::net {

/// Four numbers; nothing if it is not an IPv4 address of a host.
[[nodiscard]] std::optional<std::uint32_t> parse_ipv4(const std::string& text);

/// Errors: kUsage (domain, interface, node's name, size of GIDs).
[[nodiscard]] Status check(const RosBusOptions& options);

/// Errors: kUsage (domain, addresses, numbers of vehicles twice or out of range).
[[nodiscard]] Status check(const FleetLinkOptions& options);

/// Both require checked options.
[[nodiscard]] std::string cyclone_config(const RosBusOptions& options);
[[nodiscard]] std::string cyclone_config(const FleetLinkOptions& options);

}  // namespace rali::net
