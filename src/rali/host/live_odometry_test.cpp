#include <filesystem>

#include <gtest/gtest.h>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/drive/member_job.hpp"
#include "rali/drive/recording_events.hpp"
#include "rali/host/record_writer.hpp"
#include "rali/host/sensor_side.hpp"

namespace rali::host {
namespace {

struct Message {
  net::RosTopic topic;
  Time t;
  wire::Bytes cdr;
};

const net::RosTopic kPoints{"/points", "sensor_msgs/msg/PointCloud2", {}};
const net::RosTopic kImu{"/imu/data", "sensor_msgs/msg/Imu", {}};

/// Driver messages while the vehicle wobbles along the hall. A scan takes 12 ms to arrive.
std::vector<Message> hall_messages(double duration_s) {
  const drive::test::HallRecording hall;
  const Time start = Time::from_s(drive::test::HallRecording::kStart_s);
  Rng lidar_noise(1, "lidar"), imu_noise(1, "imu");
  std::multimap<Time, Message> messages;
  for (int tick = 0; tick < static_cast<int>(duration_s * 200.0); ++tick) {
    const Time t = start + Duration::from_s(tick / 200.0);
    const Time arrival = t + Duration::from_s(0.001);
    messages.emplace(
        arrival, Message{kImu, arrival,
                         wire::encode(hall.imu(tick / 200.0, imu_noise), wire::Encoding::kCdr)});
    if (tick % 20 != 0 || tick == 0) continue;
    const sensor::LidarScan scan = hall.scan(tick / 20 - 1, lidar_noise);
    const wire::PackedCloud packed = wire::pack_cloud(scan, "lidar", wire::CloudStyle::kVelodyne);
    const Time scan_arrival = t + Duration::from_s(0.012);
    messages.emplace(scan_arrival, Message{kPoints, scan_arrival,
                                           wire::encode(packed.view, wire::Encoding::kCdr)});
  }
  std::vector<Message> all;
  for (auto& [t, message] : messages) all.push_back(std::move(message));
  return all;
}

SensorSideSetup setup_for_hall() {
  SensorSideSetup setup;
  setup.intake.input.vehicle = "v1";
  setup.intake.input.T_body_lidar = geometry::SE3{};
  setup.intake.fleet = {"v1"};
  setup.vehicle.name = "v1";
  return setup;
}

std::vector<vehicle::PoseEstimate> poses_of(const std::vector<ToAgent>& news) {
  std::vector<vehicle::PoseEstimate> poses;
  for (const ToAgent& item : news) {
    const auto* vehicle = std::get_if<VehicleNews>(&item);
    if (vehicle == nullptr) continue;
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&vehicle->output)) {
      poses.push_back(*pose);
    }
  }
  return poses;
}

std::vector<vehicle::PoseEstimate> live_poses(const std::vector<Message>& messages,
                                              std::vector<RosOut>* published) {
  SerialExecutor executor;
  SensorSide side(setup_for_hall(), executor);
  std::vector<ToAgent> news;
  Time now;
  const Publish publish = [&](const RosOut& out) {
    if (published != nullptr) published->push_back(out);
  };
  for (const Message& message : messages) {
    now = message.t;
    side.intake().take(message.topic, message.t, message.cdr);
    side.run([&] { return now; }, publish, news);
  }
  side.finish(publish, news);
  return poses_of(news);
}

std::vector<vehicle::PoseEstimate> offline_poses(const std::string& recording) {
  drive::InputOptions options = setup_for_hall().intake.input;
  auto source = drive::open_recording_events({recording}, options);
  if (!source) return {};
  SerialExecutor executor;
  vehicle::Vehicle vehicle(VehicleId{0},
                           drive::settings_with(setup_for_hall().vehicle, (*source)->report()));
  std::vector<vehicle::PoseEstimate> poses;
  vehicle::OutputList out;
  for (;;) {
    auto event = (*source)->next();
    const bool more = event && *event;
    out.clear();
    vehicle.step(more ? **event : vehicle::Event{vehicle::EndOfData{}}, executor, out);
    for (const vehicle::Output& output : out) {
      if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) poses.push_back(*pose);
    }
    if (!more) return poses;
  }
}

TEST(LiveOdometry, live_messages_give_the_poses_of_the_same_recording_offline) {
  const std::vector<Message> messages = hall_messages(10.0);
  const std::string folder = testing::TempDir() + "live_odometry";
  std::filesystem::remove_all(folder);
  auto record = RecordWriter::create(folder, "v1");
  ASSERT_TRUE(record) << record.error().message();
  for (const Message& m : messages) ASSERT_TRUE((*record)->write(m.topic, m.t, m.cdr));
  ASSERT_TRUE((*record)->finish());

  std::vector<RosOut> published;
  const auto live = live_poses(messages, &published);
  const auto offline = offline_poses(folder + "/v1.mcap");
  ASSERT_GT(offline.size(), 90U);
  ASSERT_EQ(live.size(), offline.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    EXPECT_EQ(live[i].t, offline[i].t);
    EXPECT_EQ(live[i].T_odom_body.p, offline[i].T_odom_body.p) << i;
    EXPECT_EQ(live[i].T_odom_body.R, offline[i].T_odom_body.R) << i;
  }
  const auto odom = std::count_if(published.begin(), published.end(),
                                  [](const RosOut& out) { return out.topic == RosTopicId::kOdom; });
  EXPECT_EQ(static_cast<std::size_t>(odom), live.size());
}

TEST(LiveOdometry, outputs_a_pose_as_soon_as_its_scan_has_arrived) {
  SerialExecutor executor;
  SensorSide side(setup_for_hall(), executor);
  std::vector<ToAgent> news;
  for (const Message& message : hall_messages(6.0)) {
    side.intake().take(message.topic, message.t, message.cdr);
    news.clear();
    side.run([&] { return message.t; }, [](const RosOut&) {}, news);
    const bool late =
        seconds_between(Time::from_s(drive::test::HallRecording::kStart_s), message.t) > 4.0;
    // Inertial samples have passed the end of the scan when it arrives.
    if (late && message.topic.name == kPoints.name) {
      EXPECT_EQ(poses_of(news).size(), 1U) << message.t.s();
    }
  }
}

TEST(LiveOdometry, counts_damaged_messages_and_keeps_running) {
  std::vector<Message> messages = hall_messages(6.0);
  SerialExecutor executor;
  SensorSide side(setup_for_hall(), executor);
  std::vector<ToAgent> news;
  std::size_t clouds = 0;
  for (Message& message : messages) {
    if (message.topic.name == kPoints.name && ++clouds > 40) {
      message.cdr.resize(message.cdr.size() / 3);
    }
    side.intake().take(message.topic, message.t, message.cdr);
    side.run([&] { return message.t; }, [](const RosOut&) {}, news);
  }
  EXPECT_GT(poses_of(news).size(), 30U);
  EXPECT_GT(side.sensor_news().gaps.undecodable, 10U);
}

}  // namespace
}  // namespace rali::host
