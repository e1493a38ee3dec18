#include "rali/wire/message_kind.hpp"

#include <gtest/gtest.h>

#include "rali/wire/definitions.hpp"

namespace rali::wire {
namespace {

TEST(MessageKind, recognises_types_by_their_ros1_ros2_and_dds_names) {
  for (const char* name : {"sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2",
                           "sensor_msgs::msg::dds_::PointCloud2_"}) {
    EXPECT_EQ(message_kind(name), MessageKind::kPointCloud2) << name;
  }
  for (const char* name : {"livox_ros_driver/CustomMsg", "livox_ros_driver2/CustomMsg",
                           "livox_ros_driver2/msg/CustomMsg", "livox_interfaces/msg/CustomMsg"}) {
    EXPECT_EQ(message_kind(name), MessageKind::kLivoxCustom) << name;
  }
  EXPECT_EQ(message_kind("nlink_parser/LinktrackNodeframe2"), MessageKind::kLinktrack);
  EXPECT_EQ(message_kind("nlink_parser_ros2_interfaces/msg/LinktrackTagframe0"),
            MessageKind::kLinktrack);
  EXPECT_EQ(message_kind("tf2_msgs/msg/TFMessage"), MessageKind::kTf);
  EXPECT_EQ(message_kind("rali_msgs/msg/Range"), MessageKind::kRaliRange);
}

TEST(MessageKind, invalid_type_names_have_kind_other) {
  for (const char* name : {"", "/", "PointCloud2", "CustomMsg", "sensor_msgs/", "/PointCloud2",
                           "sensor_msgs/PointCloud22", "foo/LinktrackNodeframe9"}) {
    EXPECT_EQ(message_kind(name), MessageKind::kOther) << name;
  }
}

TEST(MessageKind, raw_packet_types_come_with_advice) {
  for (const char* name :
       {"velodyne_msgs/msg/VelodyneScan", "pandar_msgs/msg/PandarScan", "ouster_ros/PacketMsg",
        "rslidar_msg/msg/RslidarPacket", "nebula_msgs/msg/NebulaPackets"}) {
    const MessageKind kind = message_kind(name);
    EXPECT_TRUE(is_packets(kind)) << name;
    EXPECT_FALSE(is_cloud(kind));
    EXPECT_NE(kind_advice(kind).find("not points"), std::string_view::npos) << name;
  }
  EXPECT_TRUE(kind_advice(MessageKind::kPointCloud2).empty());
  EXPECT_FALSE(is_packets(MessageKind::kOther));
}

TEST(MessageKind, type_names_convert_between_ros1_and_ros2) {
  EXPECT_EQ(ros2_type_name("sensor_msgs/Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(ros2_type_name("sensor_msgs/msg/Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(ros1_type_name("sensor_msgs/msg/Imu"), "sensor_msgs/Imu");
  EXPECT_EQ(ros1_type_name("sensor_msgs::msg::dds_::Imu_"), "sensor_msgs/Imu");
  EXPECT_EQ(ros1_type_name("Imu"), "Imu");
}

TEST(Definitions, contain_every_message_once_with_separators) {
  const std::string ros2 = message_definition("nav_msgs/msg/Path", Encoding::kCdr);
  const std::string separator(80, '=');
  EXPECT_EQ(ros2.rfind("std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n", 0), 0U);
  for (const char* part :
       {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/PoseStamped",
        "geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion"}) {
    const std::string head = separator + "\nMSG: " + part + "\n";
    const std::size_t at = ros2.find(head);
    EXPECT_NE(at, std::string::npos) << part;
    EXPECT_EQ(ros2.find(head, at + 1), std::string::npos) << part;
  }
  const std::string ros1 = message_definition("nav_msgs/Path", Encoding::kRos1);
  EXPECT_NE(ros1.find("uint32 seq\ntime stamp\n"), std::string::npos);
  EXPECT_EQ(ros1.find("builtin_interfaces"), std::string::npos);
}

TEST(Definitions, exist_for_every_written_type_and_not_for_others) {
  for (const char* type : {"sensor_msgs/PointCloud2", "sensor_msgs/Imu", "tf2_msgs/TFMessage",
                           "geometry_msgs/PoseStamped", "nav_msgs/Path", "nav_msgs/Odometry",
                           "nav_msgs/OccupancyGrid", "diagnostic_msgs/DiagnosticArray",
                           "visualization_msgs/Marker", "visualization_msgs/MarkerArray",
                           "rali_msgs/Range", "std_msgs/String", "livox_ros_driver2/CustomMsg"}) {
    EXPECT_FALSE(message_definition(type, Encoding::kCdr).empty()) << type;
    EXPECT_FALSE(message_definition(type, Encoding::kRos1).empty()) << type;
    EXPECT_EQ(message_md5(type).size(), 32U) << type;
  }
  EXPECT_TRUE(message_definition("foo/Bar", Encoding::kCdr).empty());
  EXPECT_TRUE(message_md5("foo/Bar").empty());
}

}  // namespace
}  // namespace rali::wire
