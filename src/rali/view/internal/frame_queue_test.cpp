#include "rali/view/internal/frame_queue.hpp"

#include <gtest/gtest.h>

namespace rali::view {
namespace {

FramePtr frame(std::uint32_t channel, std::size_t bytes, std::int64_t t_ns = 0) {
  auto out = std::make_shared<Frame>();
  *out = {channel, Time{t_ns}, std::vector<std::uint8_t>(bytes)};
  return out;
}

TEST(FrameQueue, returns_frames_in_order_of_arrival) {
  FrameQueue queue(100);
  EXPECT_EQ(queue.push(frame(1, 10, 1)), 0U);
  EXPECT_EQ(queue.push(frame(2, 10, 2)), 0U);
  EXPECT_EQ(queue.push(frame(1, 10, 3)), 0U);
  EXPECT_EQ(queue.bytes(), 30U);
  for (const std::int64_t t : {1, 2, 3}) EXPECT_EQ((*queue.pop())->t.ns, t);
  EXPECT_FALSE(queue.pop());
  EXPECT_EQ(queue.bytes(), 0U);
}

TEST(FrameQueue, drops_the_oldest_superseded_frame_when_full) {
  FrameQueue queue(100);
  (void)queue.push(frame(1, 40, 1));
  (void)queue.push(frame(2, 40, 2));
  EXPECT_EQ(queue.push(frame(2, 40, 3)), 1U) << "frame 2 goes: 1 is the newest of its channel";
  EXPECT_EQ(queue.bytes(), 80U);
  EXPECT_EQ((*queue.pop())->t.ns, 1);
  EXPECT_EQ((*queue.pop())->t.ns, 3);
}

TEST(FrameQueue, keeps_the_newest_frame_of_each_channel_beyond_the_size_limit) {
  FrameQueue queue(100);
  (void)queue.push(frame(1, 300, 1));
  EXPECT_EQ(queue.push(frame(2, 300, 2)), 0U);
  EXPECT_EQ(queue.push(frame(1, 300, 3)), 1U);
  EXPECT_EQ(queue.size(), 2U);
  EXPECT_EQ((*queue.pop())->t.ns, 2);
  EXPECT_EQ((*queue.pop())->t.ns, 3);
}

TEST(FrameQueue, never_exceeds_its_size_limit_without_a_reader) {
  FrameQueue queue(1000);
  std::size_t dropped = 0;
  for (int i = 0; i < 100000; ++i) {
    dropped += queue.push(frame(static_cast<std::uint32_t>(i % 5), 100, i));
    ASSERT_LE(queue.bytes(), 1000U);
  }
  EXPECT_EQ(dropped + queue.size(), 100000U);
}

TEST(FrameQueue, removes_all_frames_of_an_erased_channel) {
  FrameQueue queue(100);
  (void)queue.push(frame(1, 10));
  (void)queue.push(frame(2, 20));
  (void)queue.push(frame(1, 30));
  queue.erase_channel(1);
  EXPECT_EQ(queue.bytes(), 20U);
  EXPECT_EQ((*queue.pop())->channel, 2U);
  EXPECT_FALSE(queue.pop());
}

}  // namespace
}  // namespace rali::view
