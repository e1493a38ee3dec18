#include "rali/net/dds_ros_bus.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include <gtest/gtest.h>

#include "rali/net/internal/dds_config.hpp"
#include "rali/net/internal/dds_for_test.hpp"
#include "rali/net/internal/node_info.hpp"

namespace rali::net {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr RosQos kSensor{false, false, 5};
constexpr RosQos kReliable{true, false, 50};
constexpr RosQos kLatched{true, true, 1};
const std::string kCloudType = "sensor_msgs/msg/PointCloud2";

/// CDR of `size` bytes that encode their index and `number`.
Bytes message(std::size_t size, std::uint8_t number = 0) {
  Bytes out(size);
  for (std::size_t i = 4; i < size; ++i)
    out[i] = static_cast<std::uint8_t>(i * 7 + i / 251 + number);
  out[0] = out[2] = out[3] = 0;
  out[1] = 1;
  return out;
}

/// Two buses of one domain on loopback.
class DdsRosBuses : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.domain = domain_for_test();
    options_.message_bytes_max = std::size_t{4} << 20;
    auto a = open_dds_ros_bus(options_);
    if (!a) GTEST_SKIP() << "no loopback for DDS: " << a.error().message();
    options_.node_name = "other";
    auto b = open_dds_ros_bus(options_);
    ASSERT_TRUE(b) << b.error().message();
    a_ = std::move(*a);
    b_ = std::move(*b);
  }

  [[nodiscard]] int advertise(RosBus& bus, const RosTopic& topic) {
    const auto number = bus.advertise(topic);
    EXPECT_TRUE(number) << number.error().message();
    return number.value_or(0);
  }

  [[nodiscard]] int subscribe(RosBus& bus, const RosTopic& topic) {
    const auto number = bus.subscribe(topic);
    EXPECT_TRUE(number) << number.error().message();
    return number.value_or(0);
  }

  [[nodiscard]] bool wait_for_reader(const RosBus& bus, int publication) {
    return holds_within(10.0, [&] { return bus.readers(publication) > 0; });
  }

  /// The writer discovers a reader before the reader discovers the writer.
  [[nodiscard]] bool wait_for_topic(const RosBus& bus, const std::string& name) {
    return holds_within(10.0, [&] {
      const auto topics = bus.published();
      return std::any_of(topics.begin(), topics.end(),
                         [&](const RosTopic& topic) { return topic.name == name; });
    });
  }

  [[nodiscard]] std::vector<RosMessage> take(RosBus& bus, std::size_t n) {
    std::vector<RosMessage> out;
    const double end_s = seconds_now() + 10.0;
    while (out.size() < n && seconds_now() < end_s) {
      for (RosMessage& one : bus.take(Duration::from_s(0.1))) out.push_back(std::move(one));
    }
    return out;
  }

  RosBusOptions options_;
  std::unique_ptr<RosBus> a_, b_;
};

TEST_F(DdsRosBuses, find_each_other_within_a_second) {
  const int out = advertise(*a_, {"/v1/points", kCloudType, kReliable});
  (void)subscribe(*b_, {"/v1/points", kCloudType, kSensor});
  const double start_s = seconds_now();
  EXPECT_TRUE(wait_for_reader(*a_, out));
  EXPECT_TRUE(wait_for_topic(*b_, "/v1/points"));
  EXPECT_LT(seconds_now() - start_s, 1.0);
}

TEST_F(DdsRosBuses, clouds_of_more_than_1_mb_survive_a_round_trip) {
  const RosTopic there{"/v1/points", kCloudType, kReliable}, back{"/back", kCloudType, kReliable};
  const int out = advertise(*a_, there), returned = advertise(*b_, back);
  const int in = subscribe(*b_, there);
  (void)subscribe(*a_, back);
  ASSERT_TRUE(wait_for_reader(*a_, out) && wait_for_reader(*b_, returned));
  ASSERT_TRUE(wait_for_topic(*a_, "/back") && wait_for_topic(*b_, "/v1/points"));
  for (std::uint8_t i = 0; i < 5; ++i) {
    const Bytes cloud = message(1'200'001, i);  // no multiple of four
    a_->publish(out, cloud);
    const auto arrived = take(*b_, 1);
    ASSERT_EQ(arrived.size(), 1U) << "cloud " << int{i};
    EXPECT_EQ(arrived[0].subscription, in);
    EXPECT_EQ(arrived[0].cdr, cloud);
    b_->publish(returned, arrived[0].cdr);
    const auto home = take(*a_, 1);
    ASSERT_EQ(home.size(), 1U) << "cloud " << int{i};
    EXPECT_EQ(home[0].cdr, cloud);
  }
  EXPECT_EQ(a_->counts().published, 5U);
  EXPECT_EQ(a_->counts().refused, 0U);
  EXPECT_EQ(b_->counts().arrived, 5U);
}

TEST_F(DdsRosBuses, a_late_subscriber_receives_the_last_latched_message) {
  const RosTopic map{"/map", "nav_msgs/msg/OccupancyGrid", kLatched};
  const int out = advertise(*a_, map);
  a_->publish(out, message(100, 1));
  a_->publish(out, message(300'000, 2));
  (void)subscribe(*b_, map);
  const auto arrived = take(*b_, 1);
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].cdr, message(300'000, 2));
  EXPECT_TRUE(b_->take(Duration::from_s(0.1)).empty());
}

TEST_F(DdsRosBuses, a_publisher_without_readers_neither_queues_messages_nor_blocks) {
  const int out = advertise(*a_, {"/tf", "tf2_msgs/msg/TFMessage", kReliable});
  for (int i = 0; i < 1000; ++i) a_->publish(out, message(2000));
  EXPECT_EQ(a_->counts().published, 1000U);
  (void)subscribe(*b_, {"/tf", "tf2_msgs/msg/TFMessage", kReliable});
  EXPECT_TRUE(wait_for_reader(*a_, out));
  EXPECT_TRUE(b_->take(Duration::from_s(0.1)).empty());
}

TEST_F(DdsRosBuses, a_full_subscriber_queue_drops_and_counts_the_oldest_messages) {
  const RosTopic imu{"/imu", "sensor_msgs/msg/Imu", kReliable};
  const int out = advertise(*a_, imu);
  RosTopic short_queue = imu;
  short_queue.qos.depth = 3;
  (void)subscribe(*b_, short_queue);
  ASSERT_TRUE(wait_for_reader(*a_, out) && wait_for_topic(*b_, "/imu"));
  for (std::uint8_t i = 0; i < 20; ++i) a_->publish(out, message(300, i));
  EXPECT_TRUE(holds_within(10.0, [&] { return b_->counts().arrived == 20; }));
  const auto arrived = b_->take(Duration::from_s(1.0));
  ASSERT_EQ(arrived.size(), 3U);
  EXPECT_EQ(arrived[0].cdr, message(300, 17));
  EXPECT_EQ(arrived[2].cdr, message(300, 19));
  EXPECT_EQ(b_->counts().overflowed, 17U);
}

TEST_F(DdsRosBuses, topics_of_other_participants_are_listed_with_their_types) {
  (void)advertise(*a_, {"/v1/points", kCloudType, kSensor});
  (void)advertise(*a_, {"/v1/points", "livox_ros_driver2/msg/CustomMsg", kSensor});
  (void)advertise(*a_, {"/map", "nav_msgs/msg/OccupancyGrid", kLatched});
  (void)advertise(*b_, {"/own", kCloudType, kSensor});
  EXPECT_TRUE(holds_within(10.0, [&] { return b_->published().size() == 3; }));
  const auto topics = b_->published();
  ASSERT_EQ(topics.size(), 3U);
  EXPECT_EQ(topics[0].name, "/map");
  EXPECT_TRUE(topics[0].qos.reliable && topics[0].qos.transient_local);
  EXPECT_EQ(topics[1].name, "/v1/points");
  EXPECT_EQ(topics[1].type, "livox_ros_driver2/msg/CustomMsg");
  EXPECT_FALSE(topics[1].qos.reliable || topics[1].qos.transient_local);
  EXPECT_EQ(topics[2].type, kCloudType);
  a_.reset();
  EXPECT_TRUE(holds_within(10.0, [&] { return b_->published().empty(); })) << "they are gone";
}

TEST_F(DdsRosBuses, a_best_effort_writer_does_not_match_a_reliable_reader) {
  const int out = advertise(*a_, {"/v1/points", kCloudType, kSensor});
  (void)subscribe(*b_, {"/v1/points", kCloudType, kReliable});
  (void)subscribe(*b_, {"/v1/points", "sensor_msgs/msg/Imu", kSensor});
  EXPECT_TRUE(wait_for_topic(*b_, "/v1/points"));
  EXPECT_FALSE(holds_within(0.3, [&] { return a_->readers(out) > 0; }));
}

TEST_F(DdsRosBuses, oversized_and_malformed_samples_are_dropped_and_counted) {
  RosBusOptions theirs = options_;
  theirs.message_bytes_max = std::size_t{64} << 20;
  OutsiderForTest outsider(cyclone_config(theirs), "rt/v1/points",
                           "sensor_msgs::msg::dds_::PointCloud2_");
  ASSERT_EQ(outsider.error(), "");
  outsider.open_writer(qos_for_test(true));
  (void)subscribe(*b_, {"/v1/points", kCloudType, kReliable});
  ASSERT_TRUE(holds_within(10.0, [&] { return outsider.is_matched(); }));
  ASSERT_TRUE(wait_for_topic(*b_, "/v1/points"));
  Bytes nonsense = message(100);
  nonsense[1] = 3;  // a list of parameters, as discovery has it
  EXPECT_TRUE(outsider.write(nonsense));
  EXPECT_TRUE(outsider.write(message((std::size_t{4} << 20) + 1)));
  EXPECT_TRUE(outsider.write(message(100, 9)));
  const auto arrived = take(*b_, 1);
  ASSERT_EQ(arrived.size(), 1U) << "what is whole comes after what is not; dropped "
                                << b_->counts().malformed;
  EXPECT_EQ(arrived[0].cdr, message(100, 9));
  EXPECT_EQ(b_->counts().malformed, 2U);
  EXPECT_EQ(b_->counts().arrived, 1U);
}

TEST_F(DdsRosBuses, oversized_and_malformed_messages_are_not_sent) {
  const int out = advertise(*a_, {"/v1/points", kCloudType, kSensor});
  a_->publish(out, message((std::size_t{4} << 20) + 1));
  a_->publish(out, Bytes{0, 1});
  EXPECT_EQ(a_->counts().refused, 2U);
  EXPECT_EQ(a_->counts().published, 0U);
}

TEST_F(DdsRosBuses, invalid_ros_topic_and_type_names_are_refused) {
  EXPECT_EQ(a_->advertise({"odom", kCloudType, kSensor}).error().code, ErrorCode::kInput);
  EXPECT_EQ(a_->advertise({"/odom", "sensor_msgs/PointCloud2", kSensor}).error().code,
            ErrorCode::kInput);
  EXPECT_EQ(a_->subscribe({"/odom", kCloudType, {true, false, 0}}).error().code, ErrorCode::kInput);
}

TEST_F(DdsRosBuses, announces_a_ros_2_node_with_its_topics) {
  OutsiderForTest tool(cyclone_config(options_), kNodeInfoTopic, kNodeInfoType);
  ASSERT_EQ(tool.error(), "");
  const QosPtr qos = qos_for_test(true);
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  tool.open_reader(qos);
  (void)advertise(*b_, {"/v2/odom", "nav_msgs/msg/Odometry", kReliable});
  // b_ is the node "/other" with one writer and no reader.
  bool is_seen = false;
  EXPECT_TRUE(holds_within(10.0, [&] {
    for (const Bytes& sample : tool.take()) {
      const std::string_view text(reinterpret_cast<const char*>(sample.data()), sample.size());
      is_seen = is_seen ||
                (text.find("other") != std::string_view::npos &&
                 sample.size() == encode_node_info({{}, "/", "other", {}, {Gid{}}}, 16).size());
    }
    return is_seen;
  }));

  // `ros2 node list` ignores participants without an enclave.
  const dds_entity_t reader =
      dds_create_reader(tool.participant(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr);
  std::array<void*, 16> samples{};
  std::array<dds_sample_info_t, 16> infos{};
  const dds_return_t n = dds_take(reader, samples.data(), infos.data(), 16, 16);
  int with_enclave = 0;
  for (dds_return_t i = 0; i < n; ++i) {
    const auto* participant =
        static_cast<const dds_builtintopic_participant_t*>(samples[static_cast<std::size_t>(i)]);
    void* data = nullptr;
    std::size_t size = 0;
    if (dds_qget_userdata(participant->qos, &data, &size)) {
      with_enclave +=
          std::string_view(static_cast<const char*>(data), size) == "enclave=/;" ? 1 : 0;
      dds_free(data);
    }
  }
  if (n > 0) (void)dds_return_loan(reader, samples.data(), n);
  EXPECT_EQ(with_enclave, 2);
}

TEST(DdsRosBus, options_out_of_range_are_refused) {
  const auto code_of = [](const RosBusOptions& options) {
    const auto bus = open_dds_ros_bus(options);
    return bus ? ErrorCode::kNoAnswer : bus.error().code;
  };
  RosBusOptions options;
  options.domain = 233;
  EXPECT_EQ(code_of(options), ErrorCode::kUsage);
  options = {};
  options.interface = "\"/><x";
  EXPECT_EQ(code_of(options), ErrorCode::kUsage);
  options = {};
  options.node_name = "a b";
  EXPECT_EQ(code_of(options), ErrorCode::kUsage);
  options = {};
  options.gid_bytes = 17;
  EXPECT_EQ(code_of(options), ErrorCode::kUsage);
}

TEST(DdsRosBus, a_missing_network_interface_is_named_in_the_error) {
  RosBusOptions options;
  options.domain = domain_for_test();
  options.interface = "nonet7";
  const auto bus = open_dds_ros_bus(options);
  ASSERT_FALSE(bus);
  EXPECT_EQ(bus.error().code, ErrorCode::kMachine);
  EXPECT_EQ(bus.error().where, "nonet7");
  EXPECT_NE(bus.error().message().find("ip address"), std::string::npos);
}

TEST(DdsRosBus, the_domain_is_read_from_ros_domain_id) {
  ::setenv("ROS_DOMAIN_ID", "42", 1);
  EXPECT_EQ(ros_domain_of_environment().value_or(-1), 42);
  for (const char* text : {"-1", "233", "x", "4 2", "99999999999"}) {
    ::setenv("ROS_DOMAIN_ID", text, 1);
    EXPECT_FALSE(ros_domain_of_environment()) << text;
  }
  ::unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(ros_domain_of_environment().value_or(-1), 0);
}

}  // namespace
}  // namespace rali::net
