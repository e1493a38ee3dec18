#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/net/dds_ros_bus.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::cli {
namespace {

constexpr int kMessages = 20;

wire::Bytes imu(int i, wire::Encoding encoding) {
  wire::ImuMessage out;
  out.sample.t = Time::from_s(1000.0 + 0.01 * i);
  out.sample.accel_mps2 = {0.0, 0.1 * i, 9.81};
  out.frame_id = "imu_link";
  return wire::encode(out, encoding);
}

/// A bag of ROS 1 with inertial samples of 0.2 s.
void write_bag(const std::string& path) {
  auto file = io::AtomicFile::create(path);
  ASSERT_TRUE(file);
  io::FileSink sink(std::move(*file));
  io::BagWriter bag(sink, {});
  const std::string type = "sensor_msgs/Imu";
  const auto connection =
      bag.add_connection("/imu/data", type, std::string(wire::message_md5(type)),
                         wire::message_definition(type, wire::Encoding::kRos1));
  ASSERT_TRUE(connection);
  for (int i = 0; i < kMessages; ++i) {
    ASSERT_TRUE(
        bag.write(*connection, Time::from_s(1000.0 + 0.01 * i), imu(i, wire::Encoding::kRos1)));
  }
  ASSERT_TRUE(bag.close());
  ASSERT_TRUE(sink.commit());
}

TEST(PlayCommand, a_ros_1_bag_is_received_on_the_network_as_ros_2) {
  const io::TestFolder folder;
  const std::string bag = folder.path("run.bag");
  write_bag(bag);
  net::RosBusOptions options;
  options.domain = 101 + static_cast<int>(::getpid() % 100);
  const auto bus = net::open_dds_ros_bus(options);
  if (!bus) GTEST_SKIP() << "no loopback for DDS: " << bus.error().message();
  ASSERT_TRUE((*bus)->subscribe({"/v1/imu/data", "sensor_msgs/msg/Imu", {true, false, 100}}));
  const Outcome played = run_rali(
      {"play", bag, "--vehicle", "v1", "--domain", std::to_string(options.domain), "--wait"});
  EXPECT_EQ(played.code, kExitDone) << played.err;
  EXPECT_NE(played.out.find("20 messages of 1 topic in 0."), std::string::npos) << played.out;
  const auto messages = (*bus)->take(Duration::from_s(5.0));
  ASSERT_EQ(messages.size(), static_cast<std::size_t>(kMessages));
  for (int i = 0; i < kMessages; ++i) {
    const wire::Bytes expected = imu(i, wire::Encoding::kCdr);
    const auto* raw = reinterpret_cast<const std::uint8_t*>(expected.data());
    EXPECT_EQ(messages[static_cast<std::size_t>(i)].cdr,
              (std::vector<std::uint8_t>{raw, raw + expected.size()}));
  }
}

TEST(PlayCommand, wrong_options_are_refused) {
  const io::TestFolder folder;
  const std::string bag = folder.path("run.bag");
  write_bag(bag);
  EXPECT_EQ(run_rali({"play", bag, "--rate", "0"}).code, kExitNotStarted);
  EXPECT_EQ(run_rali({"play", bag, "--vehicle", "a b"}).code, kExitNotStarted);
  EXPECT_EQ(run_rali({"play", bag, "--domain", "300"}).code, kExitNotStarted);
  EXPECT_EQ(run_rali({"play", folder.path("none.bag")}).code, kExitNotStarted);
  EXPECT_EQ(run_rali({"play", bag, "--interface", "nonet7"}).code, kExitMachine);
  const Outcome nothing = run_rali({"play", bag, "--topic", "/none"});
  EXPECT_EQ(nothing.code, kExitNotStarted);
  EXPECT_NE(nothing.err.find("/imu/data (sensor_msgs/Imu)"), std::string::npos) << nothing.err;
}

}  // namespace
}  // namespace rali::cli
