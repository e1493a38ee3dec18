#include "rali/wire/message_kind.hpp"

#include <array>

namespace rali::wire {
namespace {

struct KnownType {
  std::string_view name;  ///< in ROS 1 style
  MessageKind kind;
};

// Names as the drivers publish them (users.md section 3 and the drivers' own files).
constexpr KnownType kKnownTypes[] = {
    {"sensor_msgs/PointCloud2", MessageKind::kPointCloud2},
    {"sensor_msgs/Imu", MessageKind::kImu},
    {"livox_ros_driver/CustomMsg", MessageKind::kLivoxCustom},
    {"livox_ros_driver2/CustomMsg", MessageKind::kLivoxCustom},
    {"livox_interfaces/CustomMsg", MessageKind::kLivoxCustom},
    {"tf2_msgs/TFMessage", MessageKind::kTf},
    {"tf/tfMessage", MessageKind::kTf},
    {"geometry_msgs/PoseStamped", MessageKind::kPoseStamped},
    {"rali_msgs/Range", MessageKind::kRaliRange},
    {"std_msgs/String", MessageKind::kString},
    {"sensor_msgs/LaserScan", MessageKind::kLaserScan},
    {"sensor_msgs/MultiEchoLaserScan", MessageKind::kLaserScan},
    {"velodyne_msgs/VelodyneScan", MessageKind::kVelodynePackets},
    {"velodyne_msgs/VelodynePacket", MessageKind::kVelodynePackets},
    {"pandar_msgs/PandarScan", MessageKind::kHesaiPackets},
    {"pandar_msgs/PandarPacket", MessageKind::kHesaiPackets},
    {"hesai_lidar/PandarScan", MessageKind::kHesaiPackets},
    {"hesai_ros_driver/UdpFrame", MessageKind::kHesaiPackets},
    {"hesai_ros_driver/UdpPacket", MessageKind::kHesaiPackets},
    {"ouster_ros/PacketMsg", MessageKind::kOusterPackets},
    {"ouster_msgs/PacketMsg", MessageKind::kOusterPackets},
    {"ouster_sensor_msgs/PacketMsg", MessageKind::kOusterPackets},
    {"rslidar_msgs/rslidarScan", MessageKind::kRoboSensePackets},
    {"rslidar_msgs/rslidarPacket", MessageKind::kRoboSensePackets},
    {"rslidar_msg/RslidarPacket", MessageKind::kRoboSensePackets},
    {"rslidar_msg/RslidarScan", MessageKind::kRoboSensePackets},
    {"robosense_msgs/RobosenseScan", MessageKind::kRoboSensePackets},
    {"robosense_msgs/RobosensePacket", MessageKind::kRoboSensePackets},
    {"livox_ros_driver/LivoxPackets", MessageKind::kLivoxPackets},
    {"nebula_msgs/NebulaPackets", MessageKind::kOtherPackets},
    {"nebula_msgs/NebulaPacket", MessageKind::kOtherPackets},
    {"lslidar_msgs/LslidarScan", MessageKind::kOtherPackets},
    {"lslidar_msgs/LslidarPacket", MessageKind::kOtherPackets},
    {"udp_msgs/UdpPacket", MessageKind::kOtherPackets},
};

constexpr std::string_view kLinktrackFrames[] = {"LinktrackNodeframe2", "LinktrackNodeframe3",
                                                 "LinktrackNodeframe5", "LinktrackTagframe0"};

/// Package and bare name of a type in any of the three styles.
struct TypeParts {
  std::string_view package, name;
};

TypeParts split(std::string_view type) {
  const std::size_t package_end = type.find_first_of("/:");
  const std::size_t name_begin = type.find_last_of("/:");
  if (package_end == std::string_view::npos) return {{}, type};
  std::string_view name = type.substr(name_begin + 1);
  const bool dds = type.find("::dds_::") != std::string_view::npos;
  if (dds && !name.empty() && name.back() == '_') name.remove_suffix(1);
  return {type.substr(0, package_end), name};
}

}  // namespace

std::string ros1_type_name(std::string_view type_name) {
  const TypeParts parts = split(type_name);
  if (parts.package.empty()) return std::string(parts.name);
  return std::string(parts.package) + "/" + std::string(parts.name);
}

std::string ros2_type_name(std::string_view type_name) {
  const TypeParts parts = split(type_name);
  if (parts.package.empty()) return std::string(parts.name);
  return std::string(parts.package) + "/msg/" + std::string(parts.name);
}

MessageKind message_kind(std::string_view type_name) {
  const TypeParts parts = split(type_name);
  // The maker's package was renamed several times; the message names are its own.
  for (const std::string_view frame : kLinktrackFrames) {
    if (parts.name == frame && !parts.package.empty()) return MessageKind::kLinktrack;
  }
  for (const KnownType& known : kKnownTypes) {
    const TypeParts wanted = split(known.name);
    if (parts.package == wanted.package && parts.name == wanted.name) return known.kind;
  }
  return MessageKind::kOther;
}

bool is_cloud(MessageKind kind) {
  return kind == MessageKind::kPointCloud2 || kind == MessageKind::kLivoxCustom;
}

bool is_packets(MessageKind kind) {
  return kind >= MessageKind::kVelodynePackets && kind <= MessageKind::kOtherPackets;
}

std::string_view kind_advice(MessageKind kind) {
  switch (kind) {
    case MessageKind::kVelodynePackets:
      return "raw packets of a Velodyne, not points. Run the maker's driver (velodyne_pointcloud) "
             "to make PointCloud2 first";
    case MessageKind::kHesaiPackets:
      return "raw packets of a Hesai, not points. Run the maker's driver (hesai_ros_driver) to "
             "make PointCloud2 first";
    case MessageKind::kOusterPackets:
      return "raw packets of an Ouster, not points. Run the maker's driver (ouster_ros, with its "
             "metadata) to make PointCloud2 first";
    case MessageKind::kRoboSensePackets:
      return "raw packets of a RoboSense, not points. Run the maker's driver (rslidar_sdk) to make "
             "PointCloud2 first";
    case MessageKind::kLivoxPackets:
      return "raw packets of a Livox, not points. Run the maker's driver to make CustomMsg or "
             "PointCloud2 first";
    case MessageKind::kOtherPackets:
      return "raw sensor packets, not points. Run the maker's driver to make PointCloud2 first";
    case MessageKind::kLaserScan:
      return "a flat laser scan; RaLI needs a 3-D point cloud";
    default:
      return {};
  }
}

}  // namespace rali::wire
