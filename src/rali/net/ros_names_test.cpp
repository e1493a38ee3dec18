#include "rali/net/ros_names.hpp"

#include <gtest/gtest.h>

namespace rali::net {
namespace {

TEST(RosNames, topic_names_convert_between_ros_and_dds) {
  EXPECT_EQ(dds_topic_name("/v1/odom"), "rt/v1/odom");
  EXPECT_EQ(dds_topic_name("/tf"), "rt/tf");
  EXPECT_EQ(ros_topic_name("rt/v1/odom"), "/v1/odom");
  EXPECT_EQ(ros_topic_name("rt/_a/b_2"), "/_a/b_2");
}

TEST(RosNames, invalid_topic_names_are_refused) {
  for (const char* name : {"", "odom", "/", "/v1/", "//odom", "/v1//odom", "/1", "/v1/2d", "/a b",
                           "/a-b", "/~", "/v\xc3\xa4"}) {
    EXPECT_FALSE(dds_topic_name(name)) << name;
  }
  EXPECT_FALSE(dds_topic_name("/" + std::string(200, 'a')));
  EXPECT_TRUE(dds_topic_name("/" + std::string(199, 'a')));
  for (const char* name : {"", "rt", "rq/add/Request", "odom", "ros_discovery_info", "rt/"}) {
    EXPECT_FALSE(ros_topic_name(name)) << name;
  }
}

TEST(RosNames, type_names_convert_between_ros_and_dds) {
  EXPECT_EQ(dds_type_name("nav_msgs/msg/Odometry"), "nav_msgs::msg::dds_::Odometry_");
  EXPECT_EQ(ros_type_name("nav_msgs::msg::dds_::Odometry_"), "nav_msgs/msg/Odometry");
}

TEST(RosNames, invalid_type_names_are_refused) {
  for (const char* name : {"", "nav_msgs/Odometry", "nav_msgs/msg/", "/msg/Odometry",
                           "nav_msgs/msg/a/b", "nav_msgs/srv/Odometry", "a b/msg/C"}) {
    EXPECT_FALSE(dds_type_name(name)) << name;
  }
  for (const char* name : {"", "nav_msgs::msg::dds_::Odometry", "nav_msgs::msg::dds_::_",
                           "nav_msgs::srv::dds_::Add_Request_", "::msg::dds_::A_"}) {
    EXPECT_FALSE(ros_type_name(name)) << name;
  }
}

}  // namespace
}  // namespace rali::net
