#include "rali/cli/play/recording_player.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/wire/decode.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::cli {
namespace {

using wire::Encoding;

const Time kRecorded = Time::from_s(1000.0);

/// A recording in memory.
class FakeSource final : public io::MessageSource {
 public:
  struct Message {
    std::size_t topic = 0;
    Time t_record;
    wire::Bytes data;
  };

  void add_topic(const std::string& name, const std::string& type, Encoding encoding) {
    io::Topic topic;
    topic.name = name;
    topic.type = type;
    topic.encoding = encoding;
    topic.encoding_name = encoding == Encoding::kOther ? "json" : "";
    topics_.push_back(topic);
  }

  [[nodiscard]] const std::vector<io::Topic>& topics() const override { return topics_; }

  void select(std::function<bool(const io::Topic&)> keep) override { keep_ = std::move(keep); }

  [[nodiscard]] Result<bool> next(io::RawMessage& out) override {
    while (at_ < messages.size() && !keep_(topics_[messages[at_].topic])) ++at_;
    if (at_ == messages.size()) return false;
    const Message& message = messages[at_++];
    out = {message.topic, message.t_record, message.data, 0};
    return true;
  }

  [[nodiscard]] const io::SourceHealth& health() const override { return health_; }

  [[nodiscard]] double progress() const override { return 0.5; }

  [[nodiscard]] std::optional<std::pair<Time, Time>> span() const override { return {}; }

  [[nodiscard]] std::optional<bool> in_order() const override { return {}; }

  std::vector<Message> messages;

 private:
  std::vector<io::Topic> topics_;
  std::function<bool(const io::Topic&)> keep_;
  io::SourceHealth health_;
  std::size_t at_ = 0;
};

/// A network that records what is published.
class FakeBus final : public net::RosBus {
 public:
  struct Sent {
    std::string topic;
    Time t;
    wire::Bytes data;
  };

  explicit FakeBus(const Time& now) : now_(now) {}

  [[nodiscard]] Result<int> advertise(const net::RosTopic& topic) override {
    topics.push_back(topic);
    return static_cast<int>(topics.size()) - 1;
  }

  void publish(int publication, std::span<const std::uint8_t> cdr) override {
    const auto* raw = reinterpret_cast<const std::byte*>(cdr.data());
    sent.push_back(
        {topics.at(static_cast<std::size_t>(publication)).name, now_, {raw, raw + cdr.size()}});
  }

  [[nodiscard]] Result<int> subscribe(const net::RosTopic&) override { return 0; }

  [[nodiscard]] std::vector<net::RosMessage> take(Duration) override { return {}; }

  [[nodiscard]] std::vector<net::RosTopic> published() const override { return {}; }

  [[nodiscard]] int readers(int publication) const override {
    const std::string& name = topics.at(static_cast<std::size_t>(publication)).name;
    return static_cast<int>(std::count(received.begin(), received.end(), name));
  }

  std::vector<net::RosTopic> topics;
  std::vector<Sent> sent;
  std::vector<std::string> received;

 private:
  const Time& now_;
};

wire::Bytes range_at(Time t, Encoding encoding) {
  wire::RangeMessage range;
  range.stamp = t;
  range.from = "v1";
  range.to = "v2";
  range.range_m = 3.0;
  return wire::encode(range, encoding);
}

class Player : public ::testing::Test {
 protected:
  Player() {
    source_.add_topic("/points", "sensor_msgs/msg/PointCloud2", Encoding::kCdr);
    source_.add_topic("/imu", "sensor_msgs/msg/Imu", Encoding::kCdr);
    source_.add_topic("/ranges", "rali_msgs/msg/Range", Encoding::kCdr);
    source_.add_topic("/text", "std_msgs/msg/String", Encoding::kCdr);
    source_.add_topic("/tf_static", "tf2_msgs/msg/TFMessage", Encoding::kCdr);
  }

  void add(std::size_t topic, double after_s, wire::Bytes data) {
    source_.messages.push_back({topic, kRecorded + Duration::from_s(after_s), std::move(data)});
  }

  void add_range(double after_s) {
    add(2, after_s, range_at(kRecorded + Duration::from_s(after_s), Encoding::kCdr));
  }

  PlayTally play() {
    RecordingPlayer player(source_, bus_, options_,
                           {[this] { return now_; },
                            [this](Time t) {
                              now_ = std::max(now_, t);
                              return now_ < stop_;
                            }});
    EXPECT_TRUE(player.advertise());
    const auto tally = player.play([](double, const PlayTally&) {});
    EXPECT_TRUE(tally);
    left_out_ = player.left_out();
    published_ = player.published();
    return tally.value_or(PlayTally{});
  }

  [[nodiscard]] std::vector<double> sent_after_s() const {
    std::vector<double> out;
    for (const FakeBus::Sent& one : bus_.sent) out.push_back(seconds_between(start_, one.t));
    return out;
  }

  const Time start_ = Time::from_s(5000.0);
  Time now_ = start_, stop_ = Time::from_s(1e6);
  FakeSource source_;
  FakeBus bus_{now_};
  PlayOptions options_;
  std::vector<std::string> left_out_, published_;
};

TEST_F(Player, sends_unchanged_bytes_at_the_recorded_rate) {
  add_range(0.0);
  add_range(0.5);
  add_range(2.0);
  const PlayTally tally = play();
  EXPECT_EQ(tally.messages, 3U);
  EXPECT_EQ(sent_after_s(), (std::vector<double>{0.0, 0.5, 2.0}));
  EXPECT_EQ(bus_.sent[1].data, source_.messages[1].data);
  EXPECT_EQ(bus_.sent[1].topic, "/ranges");
}

TEST_F(Player, a_rate_of_two_takes_half_the_time) {
  options_.rate = 2.0;
  add_range(0.0);
  add_range(3.0);
  (void)play();
  EXPECT_EQ(sent_after_s(), (std::vector<double>{0.0, 1.5}));
}

TEST_F(Player, sensors_and_transforms_are_played_and_transforms_are_latched) {
  add(3, 0.0, wire::encode_string("x", Encoding::kCdr));
  add_range(0.0);
  EXPECT_EQ(play().messages, 1U);
  EXPECT_EQ(published_, (std::vector<std::string>{"/imu", "/points", "/ranges", "/tf_static"}));
  for (const net::RosTopic& topic : bus_.topics) {
    EXPECT_TRUE(topic.qos.reliable);
    EXPECT_EQ(topic.qos.transient_local, topic.name == "/tf_static");
  }
}

TEST_F(Player, prefixes_topics_except_transforms_with_the_vehicle_name) {
  options_.vehicle = "v1";
  source_.add_topic("/v1/imu", "sensor_msgs/msg/Imu", Encoding::kCdr);
  source_.add_topic("relative", "sensor_msgs/Imu", Encoding::kRos1);
  (void)play();
  EXPECT_EQ(published_, (std::vector<std::string>{"/tf_static", "/v1/imu", "/v1/points",
                                                  "/v1/ranges", "/v1/relative"}));
}

TEST_F(Player, plays_selected_topics_of_any_type) {
  options_.topics = {"/text"};
  add(3, 0.0, wire::encode_string("x", Encoding::kCdr));
  add_range(0.0);
  EXPECT_EQ(play().messages, 1U);
  EXPECT_EQ(published_, std::vector<std::string>{"/text"});
}

TEST_F(Player, converts_ros_1_messages_to_cdr) {
  source_.add_topic("/uwb", "rali_msgs/Range", Encoding::kRos1);
  source_.add_topic("/old_tf", "tf/tfMessage", Encoding::kRos1);
  const wire::Bytes whole = range_at(kRecorded, Encoding::kRos1);
  add(5, 0.0, whole);
  add(5, 0.1, {whole.begin(), whole.end() - 5});
  const PlayTally tally = play();
  EXPECT_EQ(tally.messages, 1U);
  EXPECT_EQ(tally.damaged, 1U);
  ASSERT_EQ(bus_.sent.size(), 1U);
  EXPECT_EQ(bus_.sent[0].data, range_at(kRecorded, Encoding::kCdr));
  EXPECT_TRUE(std::any_of(bus_.topics.begin(), bus_.topics.end(), [](const net::RosTopic& topic) {
    return topic.name == "/uwb" && topic.type == "rali_msgs/msg/Range";
  }));
}

TEST_F(Player, names_skipped_topics_without_definition_or_with_unsupported_encoding) {
  source_.add_topic("/odd", "livox_interfaces/CustomMsg", Encoding::kOther);
  source_.add_topic("/unknown", "my_msgs/Thing", Encoding::kRos1);
  options_.topics = {"/odd", "/unknown", "/imu"};
  (void)play();
  ASSERT_EQ(left_out_.size(), 2U);
  EXPECT_NE(left_out_[0].find("/odd: its messages are json"), std::string::npos);
  EXPECT_NE(left_out_[1].find("/unknown: "), std::string::npos);
}

TEST_F(Player, shifts_stamps_to_the_present_if_requested) {
  options_.restamp = true;
  add_range(0.0);
  add_range(0.5);
  (void)play();
  ASSERT_EQ(bus_.sent.size(), 2U);
  for (const FakeBus::Sent& one : bus_.sent) EXPECT_EQ(one.data, range_at(one.t, Encoding::kCdr));
}

TEST_F(Player, skips_long_pauses_and_clock_jumps) {
  add_range(0.0);
  add_range(1.0);
  add_range(500.0);
  add_range(500.5);
  add_range(-300.0);
  add_range(-299.0);
  add_range(-299.2);  // slightly out of order: published at once
  (void)play();
  const std::vector<double> expected{0.0, 1.0, 1.0, 1.5, 1.5, 2.5, 2.5};
  const std::vector<double> sent = sent_after_s();
  ASSERT_EQ(sent.size(), expected.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_NEAR(sent[i], expected[i], 1e-6) << i;
}

TEST_F(Player, stops_on_request) {
  stop_ = start_ + Duration::from_s(1.0);
  add_range(0.0);
  add_range(5.0);
  const PlayTally tally = play();
  EXPECT_TRUE(tally.stopped);
  EXPECT_EQ(tally.messages, 1U);
}

TEST_F(Player, is_received_once_cloud_and_imu_topics_have_readers) {
  RecordingPlayer player(source_, bus_, options_, {});
  EXPECT_FALSE(player.is_received());
  ASSERT_TRUE(player.advertise());
  bus_.received = {"/ranges", "/points"};
  EXPECT_FALSE(player.is_received());
  bus_.received = {"/imu", "/points"};
  EXPECT_TRUE(player.is_received());
}

TEST_F(Player, a_recording_without_sensors_is_refused) {
  FakeSource words;
  words.add_topic("/text", "std_msgs/msg/String", Encoding::kCdr);
  RecordingPlayer player(words, bus_, options_, {});
  const Status status = player.advertise();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().what.find("/text (std_msgs/msg/String)"), std::string::npos);
}

}  // namespace
}  // namespace rali::cli
