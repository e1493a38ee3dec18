#include "rali/wire/linktrack_serial.hpp"

#include <cstring>
#include <string>

#include <gtest/gtest.h>

namespace rali::wire {
namespace {

using Frame = std::vector<std::byte>;

template <class T>
void put_at(Frame& frame, std::size_t offset, T value) {
  std::memcpy(frame.data() + offset, &value, sizeof value);
}

void close(Frame& frame) {
  unsigned sum = 0;
  for (std::size_t i = 0; i + 1 < frame.size(); ++i) sum += std::to_integer<unsigned>(frame[i]);
  frame.back() = static_cast<std::byte>(sum & 0xffU);
}

void put_range(Frame& frame, std::size_t offset, std::int32_t millimetres) {
  for (std::size_t k = 0; k < 3; ++k) {
    frame[offset + k] = static_cast<std::byte>((millimetres >> (8 * k)) & 0xff);
  }
}

/// Nodeframe2 of radio 7 with two nodes: 12.345 m to 3, "none" to 4.
Frame nodeframe2() {
  Frame frame(119 + 2 * 13 + 1);
  put_at<std::uint8_t>(frame, 0, 0x55);
  put_at<std::uint8_t>(frame, 1, 0x04);
  put_at<std::uint16_t>(frame, 2, static_cast<std::uint16_t>(frame.size()));
  put_at<std::uint8_t>(frame, 4, 2);
  put_at<std::uint8_t>(frame, 5, 7);
  put_at<std::uint32_t>(frame, 6, 5000);    // system time
  put_at<std::uint32_t>(frame, 102, 6000);  // local time
  put_at<std::uint8_t>(frame, 118, 2);
  put_at<std::uint8_t>(frame, 120, 3);
  put_range(frame, 121, 12345);
  put_at<std::uint8_t>(frame, 124, 160);  // -80 dBm
  put_at<std::uint8_t>(frame, 125, 150);
  put_at<std::uint8_t>(frame, 133, 4);
  close(frame);
  return frame;
}

Frame nodeframe5() {
  Frame frame(24 + 10 + 1);
  put_at<std::uint8_t>(frame, 0, 0x55);
  put_at<std::uint8_t>(frame, 1, 0x08);
  put_at<std::uint16_t>(frame, 2, static_cast<std::uint16_t>(frame.size()));
  put_at<std::uint32_t>(frame, 5, 70000);
  put_at<std::uint32_t>(frame, 9, 111);
  put_at<std::uint32_t>(frame, 13, 222);
  put_at<std::uint8_t>(frame, 23, 1);
  put_at<std::uint32_t>(frame, 25, 80000);
  put_range(frame, 29, 2500);
  close(frame);
  return frame;
}

Frame tagframe0() {
  Frame frame(128);
  put_at<std::uint8_t>(frame, 0, 0x55);
  put_at<std::uint8_t>(frame, 1, 0x01);
  put_at<std::uint8_t>(frame, 2, 9);
  put_range(frame, 22 + 3 * 5, 4200);
  put_at<std::uint32_t>(frame, 108, 33);
  put_at<std::uint32_t>(frame, 112, 44);
  close(frame);
  return frame;
}

void append(Frame& out, const Frame& more) { out.insert(out.end(), more.begin(), more.end()); }

TEST(LinktrackSerial, reads_the_fields_of_each_frame) {
  LinktrackStream stream;
  stream.push(nodeframe2());
  const auto two = stream.next();
  ASSERT_TRUE(two);
  EXPECT_EQ(two->id, 7U);
  EXPECT_EQ(two->system_time_ms, 5000U);
  EXPECT_EQ(two->local_time_ms, 6000U);
  ASSERT_EQ(two->nodes.size(), 1U);
  EXPECT_EQ(two->zeros, 1U);
  EXPECT_EQ(two->nodes[0].id, 3U);
  EXPECT_NEAR(two->nodes[0].range_m, 12.345, 1e-9);
  EXPECT_EQ(two->nodes[0].fp_rssi_dbm, -80.0);
  EXPECT_EQ(two->nodes[0].rx_rssi_dbm, -75.0);
  stream.push(nodeframe5());
  const auto five = stream.next();
  ASSERT_TRUE(five);
  EXPECT_EQ(five->id, 70000U);
  EXPECT_EQ(five->nodes.at(0).id, 80000U);
  EXPECT_NEAR(five->nodes.at(0).range_m, 2.5, 1e-9);
  stream.push(tagframe0());
  const auto tag = stream.next();
  ASSERT_TRUE(tag);
  EXPECT_EQ(tag->id, 9U);
  EXPECT_EQ(tag->system_time_ms, 44U);
  EXPECT_EQ(tag->nodes.at(0).id, 5U);
  EXPECT_NEAR(tag->nodes.at(0).range_m, 4.2, 1e-9);
  EXPECT_EQ(tag->zeros, 7U);
}

// A serial port delivers bytes as they come: a read may end anywhere in a frame.
TEST(LinktrackSerial, frames_split_across_reads_are_reassembled) {
  Frame bytes = nodeframe2();
  append(bytes, tagframe0());
  append(bytes, nodeframe5());
  for (const std::size_t step : {1U, 3U, 64U, 127U}) {
    LinktrackStream stream;
    std::size_t frames = 0;
    for (std::size_t i = 0; i < bytes.size(); i += step) {
      stream.push(std::span(bytes).subspan(i, std::min(step, bytes.size() - i)));
      while (stream.next()) ++frames;
    }
    EXPECT_EQ(frames, 3U) << step;
    EXPECT_EQ(stream.tally().bytes_skipped, 0U) << step;
  }
}

TEST(LinktrackSerial, a_damaged_frame_does_not_affect_the_following_frames) {
  Frame damaged = nodeframe2();
  damaged[130] ^= std::byte{1};
  Frame bytes(3, std::byte{0x55});  // the tail of a frame that started earlier
  append(bytes, damaged);
  append(bytes, nodeframe2());
  Frame lost = nodeframe2();
  lost.resize(60);  // bytes that the port has dropped
  append(bytes, lost);
  append(bytes, tagframe0());
  LinktrackStream stream;
  stream.push(bytes);
  std::size_t frames = 0;
  while (stream.next(true)) ++frames;
  EXPECT_EQ(frames, 2U);
  EXPECT_GE(stream.tally().bad_checksums, 1U);
  EXPECT_EQ(stream.tally().bytes_skipped, 3U + damaged.size() + 60U);
}

TEST(LinktrackSerial, does_not_wait_for_a_frame_with_an_invalid_length) {
  Frame bytes = {std::byte{0x55}, std::byte{0x04}, std::byte{0xff}, std::byte{0xff}};
  append(bytes, nodeframe2());  // its bytes show that the length above is wrong
  LinktrackStream stream;
  stream.push(bytes);
  EXPECT_TRUE(stream.next());
}

}  // namespace
}  // namespace rali::wire
