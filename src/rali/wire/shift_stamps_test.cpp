#include "rali/wire/shift_stamps.hpp"

#include <gtest/gtest.h>

#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"

namespace rali::wire {
namespace {

const Time kT = Time::from_ns(1'700'000'000'900'000'000);
const Duration kShift = Duration::from_ns(100'200'000'000);

bool shift(MessageKind kind, Bytes& message, Duration by = kShift) {
  return shift_stamps(kind, "", by, message);
}

TEST(ShiftStamps, shifts_only_header_stamps) {
  for (const bool big_endian : {false, true}) {
    RangeMessage range;
    range.stamp = kT;
    range.from = "v1";
    range.range_m = 7.5;
    Bytes message = encode(range, Encoding::kCdr, big_endian);
    ASSERT_TRUE(shift(MessageKind::kRaliRange, message));
    range.stamp = Time::from_ns(1'700'000'101'100'000'000);
    EXPECT_EQ(message, encode(range, Encoding::kCdr, big_endian));
    ASSERT_TRUE(shift(MessageKind::kRaliRange, message, -kShift));
    range.stamp = kT;
    EXPECT_EQ(message, encode(range, Encoding::kCdr, big_endian));
  }
}

TEST(ShiftStamps, shifts_the_time_base_of_livox) {
  LivoxCustom livox;
  livox.stamp = kT;
  livox.frame_id = "lidar";
  livox.timebase_ns = 1'700'000'000'900'000'000;
  livox.points.resize(3);
  Bytes message = encode(livox, Encoding::kCdr);
  ASSERT_TRUE(shift(MessageKind::kLivoxCustom, message));
  livox.stamp = kT + kShift;
  livox.timebase_ns += static_cast<std::uint64_t>(kShift.ns);
  EXPECT_EQ(message, encode(livox, Encoding::kCdr));
}

TEST(ShiftStamps, shifts_every_transform) {
  TfMessage tf;
  tf.transforms = {{kT, "a", "b", {}}, {kT, "odd", "length", {}}};
  Bytes message = encode(tf, Encoding::kCdr);
  ASSERT_TRUE(shift(MessageKind::kTf, message));
  for (TransformStamped& transform : tf.transforms) transform.stamp = kT + kShift;
  EXPECT_EQ(message, encode(tf, Encoding::kCdr));
}

TEST(ShiftStamps, does_not_change_truncated_messages_or_messages_without_stamp) {
  TfMessage tf;
  tf.transforms = {{kT, "a", "b", {}}};
  const Bytes whole = encode(tf, Encoding::kCdr);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
    const Bytes before = cut;
    EXPECT_FALSE(shift(MessageKind::kTf, cut));
    EXPECT_EQ(cut, before);
  }
  Bytes text = encode_string("words", Encoding::kCdr);
  EXPECT_FALSE(shift(MessageKind::kString, text));
  EXPECT_FALSE(
      shift_stamps(MessageKind::kLinktrack, "nlink_parser/LinktrackNodeframe3", kShift, text));
}

}  // namespace
}  // namespace rali::wire
