#include "rali/wire/ros1_to_cdr.hpp"

#include <string>

#include <gtest/gtest.h>

#include "rali/wire/decode.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::wire {
namespace {

const Time kT = Time::from_ns(1'700'000'000'123'456'789);

Bytes converted(std::string_view type, std::string_view definition, const Bytes& message) {
  const auto conversion = Ros1ToCdr::make(type, definition);
  EXPECT_TRUE(conversion) << conversion.error().message();
  const auto out = conversion->convert(message);
  EXPECT_TRUE(out) << out.error().message();
  return *out;
}

Bytes converted(std::string_view type, const Bytes& message) {
  return converted(type, message_definition(type, Encoding::kRos1), message);
}

TEST(Ros1ToCdr, adds_padding_and_string_terminators_and_keeps_every_field) {
  ByteWriter in(Encoding::kRos1), out(Encoding::kCdr);
  in.put(std::uint8_t{7});
  in.put(2.5);
  in.string("ab");
  in.put(std::uint8_t{1});
  in.put(std::uint8_t{2});
  in.put(std::uint8_t{3});
  in.sequence(2);
  in.put(std::int16_t{-5});
  in.put(std::int16_t{6});
  in.time(kT);
  in.sequence(0);
  in.put(std::uint8_t{9});
  const Bytes cdr = converted("p/A",
                              "uint8 LIMIT=3 # a constant\n"
                              "string NAME=x # y\n"
                              "# a comment\r\n"
                              "uint8 a   # another\n"
                              "float64 b\n\n"
                              "string c\r\n"
                              "byte[3] d\n"
                              "int16[] e\n"
                              "time f\n"
                              "float64[] g\n"
                              "bool h",
                              in.take());
  out.put(std::uint8_t{7});
  out.put(2.5);
  out.string("ab");
  out.put(std::uint8_t{1});
  out.put(std::uint8_t{2});
  out.put(std::uint8_t{3});
  out.sequence(2);
  out.put(std::int16_t{-5});
  out.put(std::int16_t{6});
  out.time(kT);
  out.sequence(0);  // an empty sequence gets no padding for its elements
  out.put(std::uint8_t{9});
  EXPECT_EQ(cdr, out.take());
}

TEST(Ros1ToCdr, resolves_nested_types_by_package_and_drops_header_seq) {
  ByteWriter in(Encoding::kRos1), out(Encoding::kCdr);
  in.put(std::uint32_t{77});  // seq
  in.time(kT);
  in.string("lidar");
  in.sequence(1);
  in.string("x");
  in.put(1.0F);
  const Bytes cdr = converted("p/A",
                              "Header header\n"
                              "Part[] parts\n"
                              "====\n"
                              "MSG: std_msgs/Header\n"
                              "uint32 seq\n"
                              "time stamp\n"
                              "string frame_id\n"
                              "====\n"
                              "MSG: p/Part\n"
                              "string name\n"
                              "float32 seq\n",
                              in.take());
  out.header(kT, "lidar");
  out.sequence(1);
  out.string("x");
  out.put(1.0F);
  EXPECT_EQ(cdr, out.take());
}

TEST(Ros1ToCdr, gives_the_same_bytes_as_the_cdr_encoder) {
  LivoxCustom livox;
  livox.stamp = kT;
  livox.frame_id = "livox_frame";
  livox.timebase_ns = 1'700'000'000'000'000'000U;
  livox.lidar_id = 3;
  livox.points = {{1, 1.0F, 2.0F, 3.0F, 4, 5, 6}, {10, -1.0F, -2.0F, -3.0F, 7, 8, 9}};
  EXPECT_EQ(converted("livox_ros_driver2/CustomMsg", encode(livox, Encoding::kRos1)),
            encode(livox, Encoding::kCdr));
  RangeMessage range;
  range.stamp = kT;
  range.from = "v1";
  range.to = "v2";
  range.range_m = 12.5;
  range.flags = 1;
  EXPECT_EQ(converted("rali_msgs/Range", encode(range, Encoding::kRos1)),
            encode(range, Encoding::kCdr));
  ImuMessage imu;
  imu.sample.t = kT;
  imu.frame_id = "imu_link";
  imu.sample.gyro_radps = {0.1, 0.2, 0.3};
  imu.sample.accel_mps2 = {0.4, 0.5, 9.8};
  EXPECT_EQ(converted("sensor_msgs/Imu", encode(imu, Encoding::kRos1)),
            encode(imu, Encoding::kCdr));
  TfMessage tf;
  tf.transforms = {{kT, "a", "b", {}}, {kT, "b", "frame_c", {}}};
  EXPECT_EQ(converted("tf2_msgs/TFMessage", encode(tf, Encoding::kRos1)),
            encode(tf, Encoding::kCdr));
}

TEST(Ros1ToCdr, an_empty_message_gets_the_dummy_byte_of_ros_2) {
  EXPECT_EQ(converted("std_msgs/Empty", "", {}).size(), 4U + 1U);
}

TEST(Ros1ToCdr, a_truncated_message_is_refused) {
  RangeMessage range;
  range.from = "v1";
  const Bytes whole = encode(range, Encoding::kRos1);
  const auto conversion =
      Ros1ToCdr::make("rali_msgs/Range", message_definition("rali_msgs/Range", Encoding::kRos1));
  ASSERT_TRUE(conversion);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_FALSE(conversion->convert(std::span(whole).first(n))) << n;
  }
  EXPECT_TRUE(conversion->convert(whole));
}

TEST(Ros1ToCdr, a_length_beyond_the_message_is_refused) {
  const auto conversion = Ros1ToCdr::make("p/A", "p/B[] parts\n====\nMSG: p/B\nstring[] names");
  ASSERT_TRUE(conversion) << conversion.error().message();
  EXPECT_FALSE(conversion->convert(Bytes(4, std::byte{0xFF})));
}

TEST(Ros1ToCdr, invalid_definitions_are_refused) {
  for (const char* text :
       {"Missing a", "uint8", "uint8[x] a", "uint8[99999999999] a", "p/A itself",
        "B b\n====\nMSG: p/B\nA a", "B[] b\n====\nMSG: p/B\n# nothing", "uint8[-1] a"}) {
    const auto conversion = Ros1ToCdr::make("p/A", text);
    ASSERT_FALSE(conversion) << text;
    EXPECT_EQ(conversion.error().code, ErrorCode::kInput);
    EXPECT_EQ(conversion.error().where, "p/A");
  }
  // Twice as much with each level, and very many levels.
  for (const int levels : {31, 1000}) {
    std::string deep = "M0[2000] a";
    for (int i = 0; i < levels; ++i) {
      const std::string next = "M" + std::to_string(i + 1);
      deep += "\n====\nMSG: p/M" + std::to_string(i) + "\n" + next + " a\n" + next + " b";
    }
    deep += "\n====\nMSG: p/M" + std::to_string(levels) + "\nuint8 a";
    EXPECT_FALSE(Ros1ToCdr::make("p/A", deep)) << levels;
  }
}

}  // namespace
}  // namespace rali::wire
