#include "rali/drive/ranges/range_topics.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/wire/byte_writer.hpp"
#include "rali/wire/encode.hpp"

namespace rali::drive {
namespace {

using sensor::RangeSample;

/// LinkTrack Nodeframe3 of one neighbour.
wire::Bytes frame(int self, int peer, float range_m, std::uint32_t system_ms) {
  wire::ByteWriter out(wire::Encoding::kRos1);
  out.put(std::uint8_t{2});
  out.put(static_cast<std::uint8_t>(self));
  out.put(system_ms + 500);
  out.put(system_ms);
  out.put(4.9F);
  out.put(std::uint32_t{1});
  out.put(std::uint8_t{2});
  out.put(static_cast<std::uint8_t>(peer));
  out.put(range_m);
  out.put(-80.0F);
  out.put(-78.0F);
  return out.take();
}

RecordedMessage message_of(const wire::Bytes& bytes, double t_record_s) {
  RecordedMessage message;
  message.kind = wire::MessageKind::kLinktrack;
  message.topic = "/uwb";
  message.type = "nlink_parser/LinktrackNodeframe3";
  message.encoding = wire::Encoding::kRos1;
  message.t_record = Time::from_s(t_record_s);
  message.data = bytes;
  return message;
}

std::shared_ptr<RangeOptions> options() {
  auto o = std::make_shared<RangeOptions>();
  o->names = {{"v1", {VehicleId{0}, 0}}, {"v1/rear", {VehicleId{0}, 1}}, {"v2", {VehicleId{1}, 0}}};
  o->antennas = {2, 1};
  o->topics = {{"/uwb", {{4, {VehicleId{0}, 1}}, {7, {VehicleId{1}, 0}}}}};
  return o;
}

std::vector<RangeSample> taken(RangeTopics& topics, const RecordedMessage& message) {
  std::vector<RangeSample> samples;
  EXPECT_TRUE(topics.take(message, samples));
  return samples;
}

TEST(RangeTopics, radio_numbers_are_mapped_to_antennas_of_vehicles) {
  RangeTopics topics(options(), VehicleId{0}, Duration{});
  const wire::Bytes bytes = frame(4, 7, 3.25F, 1000);
  ASSERT_TRUE(topics.wants(message_of(bytes, 5.0)));
  const auto samples = taken(topics, message_of(bytes, 5.0));
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].from, VehicleId{0});
  EXPECT_EQ(samples[0].from_antenna, 1);
  EXPECT_EQ(samples[0].to, VehicleId{1});
  EXPECT_EQ(samples[0].range_m, 3.25);
  EXPECT_EQ(samples[0].rssi_dbm, -78.0);
  EXPECT_EQ(samples[0].first_path_dbm, -80.0);
  EXPECT_EQ(samples[0].t, Time::from_s(5.0)) << "the first arrival is all that is known";
}

TEST(RangeTopics, an_unlisted_sender_is_the_recording_vehicle_and_an_unlisted_peer_unknown) {
  RangeTopics topics(options(), VehicleId{1}, Duration{});
  const auto samples = taken(topics, message_of(frame(99, 12, 3.0F, 1000), 5.0));
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].from, VehicleId{1});
  EXPECT_EQ(samples[0].to, unknown_radio(12));
  EXPECT_TRUE(taken(topics, message_of(frame(99, 7, 3.0F, 1050), 5.05)).empty())
      << "two radios of one vehicle measure no range between vehicles";
}

TEST(RangeTopics, a_late_message_keeps_the_time_of_its_radio_clock) {
  RangeTopics by_radio(options(), VehicleId{0}, Duration{});
  auto record = options();
  record->stamp = RangeStamp::kRecord;
  RangeTopics by_record(record, VehicleId{0}, Duration{});
  Time t_radio, t_record;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const double late_s = i == 99 ? 0.2 : 0.0;
    const wire::Bytes bytes = frame(4, 7, 3.0F, 1000 + 50 * i);
    const RecordedMessage message = message_of(bytes, 5.0 + 0.05 * i + late_s);
    t_radio = taken(by_radio, message).at(0).t;
    t_record = taken(by_record, message).at(0).t;
  }
  EXPECT_NEAR(t_radio.s(), 5.0 + 0.05 * 99, 1e-3);
  EXPECT_NEAR(t_record.s(), 5.2 + 0.05 * 99, 1e-9);
}

TEST(RangeTopics, arrival_times_are_converted_to_the_sensor_clock_minus_latency) {
  auto o = options();
  o->latency_s = 0.1;
  RangeTopics topics(o, VehicleId{0}, Duration::from_s(1000.0));
  EXPECT_NEAR(taken(topics, message_of(frame(4, 7, 3.0F, 1000), 5.0)).at(0).t.s(), 1004.9, 1e-6);
}

TEST(RangeTopics, messages_with_vehicle_names_need_no_radio_numbers) {
  wire::RangeMessage range;
  range.stamp = Time::from_s(8.0);
  range.from = "v1";
  range.antenna = "rear";
  range.to = "v2";
  range.range_m = 4.5;
  range.rssi_dbm = std::numeric_limits<float>::quiet_NaN();
  range.sigma_m = 0.2F;
  RangeTopics topics(options(), VehicleId{0}, Duration{});
  const auto take = [&] {
    const wire::Bytes bytes = wire::encode(range, wire::Encoding::kCdr);
    RecordedMessage message = message_of(bytes, 9.0);
    message.kind = wire::MessageKind::kRaliRange;
    message.encoding = wire::Encoding::kCdr;
    return taken(topics, message);
  };
  const auto samples = take();
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].from_antenna, 1);
  EXPECT_EQ(samples[0].t, Time::from_s(8.0));
  EXPECT_EQ(samples[0].rssi_dbm, 0.0) << "not known";
  EXPECT_NEAR(samples[0].sigma_m, 0.2, 1e-6);
  range.to = "v9";
  range.stamp = Time{};
  EXPECT_EQ(take().at(0).to, kNobody);
  EXPECT_EQ(take().at(0).t, Time::from_s(9.0)) << "no stamp: the recorder's";
}

TEST(RangeTopics, refuses_truncated_messages_and_ignores_other_topics) {
  RangeTopics topics(options(), VehicleId{0}, Duration{});
  const wire::Bytes whole = frame(4, 7, 3.0F, 1000);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const wire::Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
    std::vector<RangeSample> samples;
    EXPECT_FALSE(topics.take(message_of(cut, 5.0), samples)) << n;
    EXPECT_TRUE(samples.empty());
  }
  RecordedMessage other = message_of(whole, 5.0);
  other.topic = "/other";
  EXPECT_FALSE(topics.wants(other));
  EXPECT_FALSE(RangeTopics(nullptr, VehicleId{0}, Duration{}).wants(message_of(whole, 5.0)));
}

}  // namespace
}  // namespace rali::drive
