#include "rali/drive/input/topic_choice.hpp"

#include <gtest/gtest.h>

#include "rali/drive/input/tf_tree.hpp"

namespace rali::drive {
namespace {

TopicCount topic(const std::string& name, const std::string& type, std::uint64_t n) {
  return {name, type, wire::message_kind(type), n, true};
}

const std::string kCloud = "sensor_msgs/PointCloud2", kImu = "sensor_msgs/msg/Imu";

TEST(TopicChoice, finds_the_only_cloud_and_imu) {
  const std::vector<TopicCount> topics = {topic("/tf", "tf2_msgs/TFMessage", 9),
                                          topic("/points", kCloud, 100), topic("/imu", kImu, 900)};
  const auto choice = choose_topics(topics, {}, "v1.bag");
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->lidar, "/points");
  EXPECT_EQ(choice->imu, "/imu");
}

TEST(TopicChoice, refuses_two_cloud_topics_and_lists_their_message_counts) {
  const std::vector<TopicCount> topics = {topic("/rslidar_points", kCloud, 1203),
                                          topic("/ouster/points", kCloud, 1203)};
  const auto choice = choose_topics(topics, {}, "v1.bag");
  ASSERT_FALSE(choice);
  EXPECT_EQ(choice.error().message(),
            "v1.bag: 2 point cloud topics: /ouster/points (1203), /rslidar_points (1203). Choose "
            "with vehicles.v1.lidar.topic or --lidar-topic.");
}

TEST(TopicChoice, skips_an_announced_topic_without_messages) {
  const std::vector<TopicCount> topics = {topic("/a", kCloud, 0), topic("/b", kCloud, 7)};
  EXPECT_EQ(choose_topics(topics, {}, "f")->lidar, "/b");
}

TEST(TopicChoice, refuses_raw_packets_and_names_the_sensor) {
  const std::vector<TopicCount> topics = {
      topic("/velodyne_packets", "velodyne_msgs/msg/VelodyneScan", 4)};
  const auto choice = choose_topics(topics, {}, "v.db3");
  ASSERT_FALSE(choice);
  EXPECT_NE(choice.error().message().find("raw packets of a Velodyne, not points"),
            std::string::npos)
      << choice.error().message();
}

TEST(TopicChoice, refuses_a_named_topic_that_is_something_else_or_absent) {
  const std::vector<TopicCount> topics = {topic("/imu", kImu, 4), topic("/p", kCloud, 4)};
  InputOptions options;
  options.lidar_topic = "/imu";
  EXPECT_NE(choose_topics(topics, options, "f").error().what.find("not a point cloud"),
            std::string::npos);
  options.lidar_topic = "/q";
  const auto absent = choose_topics(topics, options, "f");
  EXPECT_EQ(absent.error().message(), "f: no topic /q. There is /p (4).");
}

TEST(TopicChoice, uses_no_imu_if_the_topic_is_none) {
  const std::vector<TopicCount> topics = {topic("/imu", kImu, 4), topic("/p", kCloud, 4)};
  InputOptions options;
  options.imu_topic = "none";
  EXPECT_EQ(choose_topics(topics, options, "f")->imu, "");
}

TEST(TfTree, chains_transforms_up_and_down) {
  TfTree tree;
  wire::TransformStamped tf;
  tf.frame_id = "base_link";
  tf.child_frame_id = "imu";
  tf.T_frame_child.p = {0.0, 0.0, 0.5};
  tree.add(tf);
  tf.child_frame_id = "/lidar";
  tf.T_frame_child.p = {1.0, 0.0, 0.8};
  tree.add(tf);
  const auto T_imu_lidar = tree.find("imu", "lidar");
  ASSERT_TRUE(T_imu_lidar);
  EXPECT_TRUE(T_imu_lidar->p.isApprox(geometry::Vec3(1.0, 0.0, 0.3)));
  EXPECT_FALSE(tree.find("imu", "camera"));
}

TEST(TfTree, does_not_hang_on_a_loop) {
  TfTree tree;
  wire::TransformStamped tf;
  tf.frame_id = "a";
  tf.child_frame_id = "b";
  tree.add(tf);
  std::swap(tf.frame_id, tf.child_frame_id);
  tree.add(tf);
  (void)tree.find("a", "c");
  (void)tree.find("c", "b");
}

}  // namespace
}  // namespace rali::drive
