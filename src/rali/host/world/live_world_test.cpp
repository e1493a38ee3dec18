#include "rali/host/world/live_world.hpp"

#include <gtest/gtest.h>

#include "rali/host/world/bus_for_test.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"

namespace rali::host {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr const char* kStatusTopic = "/v2/navigate_to_pose/_action/status";

class LiveWorldTest : public testing::Test {
 protected:
  void SetUp() override {
    auto made = LiveWorld::make(bus_, {{"v1", "v2"}, sim::Lidar::kVlp16}, [this](Time now) {
      waited_.push_back(now);
      return go_on_;
    });
    ASSERT_TRUE(made) << made.error().message();
    world_ = std::move(*made);
  }

  std::vector<sim::DriveCommand> decide(double t_s, sim::DriveReport v2 = {}) {
    const std::vector<sim::DriveReport> reports{{}, v2};
    return world_->decide(Time::from_s(t_s), reports);
  }

  void send_goal(const Vec3& p_map_m, const std::string& frame = "map") {
    const wire::PoseStamped goal{Time::from_s(1.0), frame, {geometry::Mat3::Identity(), p_map_m}};
    bus_.arrive("/v2/goal_pose", wire::encode(goal, wire::Encoding::kCdr));
  }

  /// In the map, v2's odom is at x = 10; in odom, v2 is at y = 1.
  void send_pose() {
    wire::TfMessage tf;
    tf.transforms.push_back({Time::from_s(1.0), "map", "v2/odom",
                             SE3{geometry::Mat3::Identity(), Vec3(10.0, 0.0, 0.0)}});
    bus_.arrive("/tf", wire::encode(tf, wire::Encoding::kCdr));
    wire::Odometry odometry;
    odometry.stamp = Time::from_s(0.9);
    odometry.frame_id = "v2/odom";
    odometry.T_frame_child.p = {0.0, 1.0, 0.0};
    bus_.arrive("/v2/odom", wire::encode(odometry, wire::Encoding::kCdr));
  }

  [[nodiscard]] wire::GoalStatus last_status() const {
    const auto& sent = bus_.sent.at(kStatusTopic);
    const auto read = wire::decode_goal_status(std::as_bytes(std::span(sent.back())));
    return read.value().goals.at(0);
  }

  BusForTest bus_;
  std::unique_ptr<LiveWorld> world_;
  std::vector<Time> waited_;
  bool go_on_ = true;
};

TEST_F(LiveWorldTest, publishes_sensors_under_the_vehicle_name_and_ranges_at_both_ends) {
  world_->on_message({1, sensor::ImuSample{}});
  sensor::RangeSample range;
  range.from = VehicleId{0};
  range.to = VehicleId{1};
  range.range_m = 7.5;
  world_->on_message({0, range});
  EXPECT_EQ(bus_.sent.at("/v2/imu/data").size(), 1U);
  EXPECT_FALSE(bus_.sent.contains("/v1/imu/data"));
  for (const char* topic : {"/v1/uwb", "/v2/uwb"}) {
    ASSERT_EQ(bus_.sent.at(topic).size(), 1U) << "both radios know the range";
    const auto read =
        wire::decode_range(std::as_bytes(std::span(bus_.sent.at(topic)[0])), wire::Encoding::kCdr);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->from, "v1");
    EXPECT_EQ(read->to, "v2");
    EXPECT_EQ(read->range_m, 7.5);
  }
}

TEST_F(LiveWorldTest, a_goal_waits_for_the_map_pose_of_the_vehicle) {
  send_goal({12.0, 3.0, 0.0});
  EXPECT_TRUE(decide(1.0).empty());
  send_pose();
  const auto commands = decide(1.1);
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].vehicle, 1);
  EXPECT_EQ(commands[0].places_map_m.at(0), Vec3(12.0, 3.0, 0.0));
  EXPECT_EQ(commands[0].T_map_body.p, Vec3(10.0, 1.0, 0.0));
  EXPECT_EQ(commands[0].t, Time::from_s(0.9));
  EXPECT_TRUE(decide(1.2).empty()) << "a goal is one command";
}

TEST_F(LiveWorldTest, the_status_refers_to_the_newest_goal) {
  send_pose();
  send_goal({12.0, 3.0, 0.0});
  ASSERT_EQ(decide(1.0).size(), 1U);
  const auto first = last_status();
  EXPECT_EQ(first.state, wire::GoalStatus::kAccepted);
  static_cast<void>(decide(1.1, {sim::DriveStatus::kDriving, 1}));
  EXPECT_EQ(last_status().state, wire::GoalStatus::kExecuting);
  static_cast<void>(decide(5.0, {sim::DriveStatus::kArrived, 1}));
  EXPECT_EQ(last_status().state, wire::GoalStatus::kSucceeded);
  send_goal({0.0, 0.0, 0.0});
  static_cast<void>(decide(6.0, {sim::DriveStatus::kArrived, 1}));
  EXPECT_EQ(last_status().state, wire::GoalStatus::kAccepted) << "the report is of the old goal";
  EXPECT_NE(last_status().goal_id, first.goal_id);
  static_cast<void>(decide(6.1, {sim::DriveStatus::kUnreachable, 2}));
  EXPECT_EQ(last_status().state, wire::GoalStatus::kAborted);
}

TEST_F(LiveWorldTest, counts_and_ignores_invalid_goals) {
  send_pose();
  send_goal({12.0, 3.0, 0.0}, "v2/odom");
  send_goal({std::nan(""), 3.0, 0.0});
  bus_.arrive("/v2/goal_pose", {std::byte{0}, std::byte{1}});
  bus_.arrive("/v2/odom", {std::byte{0}});
  bus_.arrive("/tf", {});
  EXPECT_TRUE(decide(1.0).empty());
  EXPECT_EQ(world_->counts().unreadable, 5U);
  EXPECT_EQ(world_->counts().goals, 0U);
}

TEST_F(LiveWorldTest, waits_for_the_clock_and_ends_when_the_clock_stops) {
  static_cast<void>(decide(1.0));
  EXPECT_FALSE(world_->finished());
  go_on_ = false;
  static_cast<void>(decide(1.1));
  EXPECT_TRUE(world_->finished());
  EXPECT_EQ(waited_, (std::vector<Time>{Time::from_s(1.0), Time::from_s(1.1)}));
}

TEST_F(LiveWorldTest, lists_vehicles_whose_lidar_topic_has_no_subscriber) {
  EXPECT_EQ(world_->unsubscribed(), (std::vector<std::string>{"v1", "v2"}));
  bus_.listened["/v1/velodyne_points"] = 1;
  EXPECT_EQ(world_->unsubscribed(), (std::vector<std::string>{"v2"}));
}

}  // namespace
}  // namespace rali::host
