#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace rali::net {

using Gid = std::array<std::uint8_t, 16>;

inline constexpr const char* kNodeInfoTopic = "ros_discovery_info";
inline constexpr const char* kNodeInfoType = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";

/// Data that `ros2 node list` and `ros2 node info` show for a participant with one node.
struct NodeInfo {
  Gid participant{};
  std::string node_namespace, node_name;
  std::vector<Gid> readers, writers;
};

/// rmw_dds_common/msg/ParticipantEntitiesInfo in CDR. @param gid_bytes 16, or 24 as in Humble
[[nodiscard]] std::vector<std::uint8_t> encode_node_info(const NodeInfo& info, int gid_bytes);

}  // namespace rali::net
