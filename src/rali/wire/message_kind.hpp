#pragma once

#include <string>
#include <string_view>

namespace rali::wire {

/// How RaLI can use a topic, by its type's name.
enum class MessageKind {
  kPointCloud2,
  kImu,
  kLivoxCustom,
  kTf,  ///< TFMessage; /tf and /tf_static differ by topic only
  kPoseStamped,
  kLinktrack,  ///< Nodeframe2, 3, 5, Tagframe0
  kRaliRange,
  kString,
  kLaserScan,        ///< a flat scanner: no 3-D cloud
  kVelodynePackets,  ///< from here: raw packets, not points
  kHesaiPackets,
  kOusterPackets,
  kRoboSensePackets,
  kLivoxPackets,
  kOtherPackets,
  kOther
};

/// "sensor_msgs/PointCloud2" for "sensor_msgs/msg/PointCloud2" and for
/// "sensor_msgs::msg::dds_::PointCloud2_"; ROS 1 names stay as they are.
[[nodiscard]] std::string ros1_type_name(std::string_view type_name);

/// "sensor_msgs/msg/PointCloud2" for "sensor_msgs/PointCloud2".
[[nodiscard]] std::string ros2_type_name(std::string_view type_name);

/// Accepts names of ROS 1, ROS 2 and DDS, in any file.
[[nodiscard]] MessageKind message_kind(std::string_view type_name);

/// True for topics that hold points RaLI can read.
[[nodiscard]] bool is_cloud(MessageKind kind);

/// True for the raw packet types.
[[nodiscard]] bool is_packets(MessageKind kind);

/// For LiDAR data that cannot be read: its kind and a remedy, e.g. "raw packets of a Velodyne, not
/// points. Run the maker's driver to make PointCloud2 first". Empty for others.
[[nodiscard]] std::string_view kind_advice(MessageKind kind);

}  // namespace rali::wire
