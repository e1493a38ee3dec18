#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Mapping of ROS 2 names to DDS (design.ros2.org "Topic and Service name mapping to DDS").
namespace rali::net {

/// "rt/v1/odom" for "/v1/odom"; nothing if it is not an absolute topic name: parts of letters,
/// digits and underscores that do not begin with a digit, at most 200 characters.
[[nodiscard]] std::optional<std::string> dds_topic_name(std::string_view ros_name);

/// "nav_msgs::msg::dds_::Odometry_" for "nav_msgs/msg/Odometry"; nothing for other texts.
[[nodiscard]] std::optional<std::string> dds_type_name(std::string_view ros_type);

/// "/v1/odom" for "rt/v1/odom"; nothing for topics outside ROS, and for services.
[[nodiscard]] std::optional<std::string> ros_topic_name(std::string_view dds_name);

/// "nav_msgs/msg/Odometry" for "nav_msgs::msg::dds_::Odometry_"; nothing for other texts.
[[nodiscard]] std::optional<std::string> ros_type_name(std::string_view dds_type);

}  // namespace rali::net
