#include "rali/wire/decode.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "rali/geometry/so3.hpp"
#include "rali/wire/byte_writer.hpp"
#include "rali/wire/encode.hpp"

namespace rali::wire {
namespace {

struct World {
  Encoding encoding;
  bool big_endian;
};

constexpr World kWorlds[] = {
    {Encoding::kRos1, false}, {Encoding::kCdr, false}, {Encoding::kCdr, true}};

/// Every prefix must be refused, without a crash.
void refuses_every_prefix(const Bytes& message,
                          const std::function<bool(std::span<const std::byte>)>& decodes) {
  for (std::size_t size = 0; size < message.size(); ++size) {
    // A block of exactly this size, so that the sanitizers detect a read past the end.
    const Bytes cut(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decodes(cut)) << size << " of " << message.size() << " bytes";
  }
  EXPECT_TRUE(decodes(message));
}

CloudView two_points(const std::array<std::byte, 32>& data) {
  CloudView cloud;
  cloud.stamp = Time::from_ns(12'000'000'034);
  cloud.frame_id = "lidar";
  cloud.height = 1;
  cloud.width = 2;
  cloud.point_step = 16;
  cloud.row_step = 32;
  cloud.fields = {{"x", 0, FieldType::kFloat32, 1}, {"ring", 12, FieldType::kUint16, 1}};
  cloud.data = data;
  return cloud;
}

TEST(Decode, point_cloud2_survives_a_round_trip_in_every_encoding) {
  std::array<std::byte, 32> data{};
  data[17] = std::byte{0x5A};
  for (const World world : kWorlds) {
    const Bytes message = encode(two_points(data), world.encoding, world.big_endian);
    const Result<CloudView> cloud = decode_point_cloud2(message, world.encoding);
    ASSERT_TRUE(cloud.has_value());
    EXPECT_EQ(cloud->stamp.ns, 12'000'000'034);
    EXPECT_EQ(cloud->frame_id, "lidar");
    EXPECT_EQ(cloud->width, 2U);
    EXPECT_EQ(cloud->point_step, 16U);
    ASSERT_EQ(cloud->fields.size(), 2U);
    EXPECT_EQ(cloud->fields[1].name, "ring");
    EXPECT_EQ(cloud->fields[1].type, FieldType::kUint16);
    ASSERT_EQ(cloud->data.size(), 32U);
    EXPECT_EQ(cloud->data[17], std::byte{0x5A});
    EXPECT_FALSE(cloud->big_endian);
    refuses_every_prefix(Bytes(message.begin(), message.end() - 1), [&](auto bytes) {
      return decode_point_cloud2(bytes, world.encoding).has_value();
    });
  }
}

TEST(Decode, point_cloud2_with_a_hostile_field_list_is_refused) {
  ByteWriter out(Encoding::kRos1);
  out.header(Time{}, "");
  out.put(std::uint32_t{1});
  out.put(std::uint32_t{1});
  out.put(std::uint32_t{0xFFFFFFFF});
  EXPECT_FALSE(decode_point_cloud2(out.take(), Encoding::kRos1).has_value());
}

TEST(Decode, encoder_does_not_pad_gigabytes_for_a_hostile_point_step) {
  std::array<std::byte, 32> data{};
  CloudView cloud = two_points(data);
  cloud.point_step = 0xFFFFFFF0;
  EXPECT_LT(encode(cloud, Encoding::kRos1).size(), 200U);
  cloud.point_step = 17;  // 32 bytes are one point and 15 of the next: 2 are missing
  const Bytes padded = encode(cloud, Encoding::kCdr);
  EXPECT_EQ(decode_point_cloud2(padded, Encoding::kCdr)->data.size(), 34U);
}

TEST(Decode, imu_gyro_and_accelerometer_survive_a_round_trip) {
  ImuMessage imu;
  imu.sample = {Time::from_ns(5'000'000'001), {0.1, -0.2, 0.3}, {1.0, 2.0, 9.81}};
  imu.frame_id = "imu_link";
  for (const World world : kWorlds) {
    const Bytes message = encode(imu, world.encoding, world.big_endian);
    // header + 37 doubles; ROS 1: 4 + 8 + 4 + 8 bytes of header
    if (world.encoding == Encoding::kRos1) {
      EXPECT_EQ(message.size(), 24U + 37 * 8);
    }
    const Result<ImuMessage> back = decode_imu(message, world.encoding);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->sample.t.ns, 5'000'000'001);
    EXPECT_EQ(back->sample.gyro_radps, imu.sample.gyro_radps);
    EXPECT_EQ(back->sample.accel_mps2, imu.sample.accel_mps2);
    EXPECT_EQ(back->frame_id, "imu_link");
    refuses_every_prefix(message,
                         [&](auto bytes) { return decode_imu(bytes, world.encoding).has_value(); });
  }
}

TEST(Decode, livox_points_are_19_bytes_in_ros1_and_20_in_cdr) {
  LivoxCustom custom;
  custom.stamp = Time::from_ns(1'000'000'000);
  custom.frame_id = "livox_frame";
  custom.timebase_ns = 1'000'000'000;
  custom.points = {{0, 1.0F, 2.0F, 3.0F, 10, 0, 1}, {100'000, -1.0F, -2.0F, -3.0F, 20, 16, 3}};
  for (const World world : kWorlds) {
    const Bytes message = encode(custom, world.encoding, world.big_endian);
    const Result<CloudView> cloud = decode_livox_custom(message, world.encoding);
    ASSERT_TRUE(cloud.has_value());
    const std::size_t step = world.encoding == Encoding::kRos1 ? 19 : 20;
    EXPECT_EQ(cloud->point_step, step);
    EXPECT_EQ(cloud->data.size(), step + 19);
    EXPECT_EQ(cloud->big_endian, world.big_endian && world.encoding == Encoding::kCdr);
    const std::byte* second = cloud->data.data() + step;
    EXPECT_EQ(load<std::uint32_t>(second, cloud->big_endian), 100'000U);
    EXPECT_EQ(load<float>(second + 12, cloud->big_endian), -3.0F);
    EXPECT_EQ(std::to_integer<int>(second[18]), 3);
    refuses_every_prefix(message, [&](auto bytes) {
      return decode_livox_custom(bytes, world.encoding).has_value();
    });
  }
}

TEST(Decode, livox_without_a_header_stamp_uses_the_time_base) {
  LivoxCustom custom;
  custom.timebase_ns = 77;
  const Bytes message = encode(custom, Encoding::kRos1);
  EXPECT_EQ(decode_livox_custom(message, Encoding::kRos1)->stamp.ns, 77);
  EXPECT_EQ(decode_livox_custom(message, Encoding::kRos1)->width, 0U);
}

TEST(Decode, transforms_survive_a_round_trip) {
  TfMessage tf;
  TransformStamped transform;
  transform.stamp = Time::from_ns(3);
  transform.frame_id = "base_link";
  transform.child_frame_id = "lidar";
  transform.T_frame_child.p = {0.1, 0.2, 0.3};
  tf.transforms.push_back(transform);
  // all four branches of the quaternion: small angle and half turns about each axis
  for (const geometry::Vec3& phi : {geometry::Vec3(0.1, 0.2, 0.3), geometry::Vec3(3.1, 0.1, 0.0),
                                    geometry::Vec3(0.0, 3.1, 0.1), geometry::Vec3(0.1, 0.0, 3.1)}) {
    tf.transforms[0].T_frame_child.R = geometry::so3_exp(phi);
    for (const World world : kWorlds) {
      const Bytes message = encode(tf, world.encoding, world.big_endian);
      const Result<TfMessage> back = decode_tf(message, world.encoding);
      ASSERT_TRUE(back.has_value());
      ASSERT_EQ(back->transforms.size(), 1U);
      const TransformStamped& got = back->transforms[0];
      EXPECT_EQ(got.frame_id, "base_link");
      EXPECT_EQ(got.child_frame_id, "lidar");
      EXPECT_TRUE(got.T_frame_child.R.isApprox(tf.transforms[0].T_frame_child.R, 1e-12));
      EXPECT_EQ(got.T_frame_child.p, transform.T_frame_child.p);
      refuses_every_prefix(
          message, [&](auto bytes) { return decode_tf(bytes, world.encoding).has_value(); });
    }
  }
}

TEST(Decode, a_transform_with_a_zero_quaternion_is_skipped_and_counted) {
  ByteWriter out(Encoding::kRos1);
  out.sequence(2);
  for (int i = 0; i < 2; ++i) {
    out.header(Time{}, "a");
    out.string("b");
    for (int k = 0; k < 6; ++k) out.put(0.0);
    out.put(i == 0 ? 0.0 : 1.0);
  }
  const Result<TfMessage> tf = decode_tf(out.take(), Encoding::kRos1);
  ASSERT_TRUE(tf.has_value());
  EXPECT_EQ(tf->transforms.size(), 1U);
  EXPECT_EQ(tf->refused, 1U);
}

TEST(Decode, pose_range_and_string_survive_a_round_trip) {
  PoseStamped pose;
  pose.stamp = Time::from_ns(9);
  pose.frame_id = "map";
  pose.T_frame_body.p = {1, 2, 3};
  RangeMessage range;
  range.stamp = Time::from_ns(4);
  range.antenna = "uwb";
  range.from = "v1";
  range.to = "v2";
  range.range_m = 12.5;
  range.sigma_m = 0.1F;
  range.device_time_ns = 123456789012345ULL;
  range.flags = 3;
  for (const World world : kWorlds) {
    const Bytes pose_bytes = encode(pose, world.encoding, world.big_endian);
    EXPECT_EQ(decode_pose_stamped(pose_bytes, world.encoding)->T_frame_body.p, pose.T_frame_body.p);
    refuses_every_prefix(pose_bytes, [&](auto bytes) {
      return decode_pose_stamped(bytes, world.encoding).has_value();
    });
    const Bytes range_bytes = encode(range, world.encoding, world.big_endian);
    const Result<RangeMessage> back = decode_range(range_bytes, world.encoding);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->from, "v1");
    EXPECT_EQ(back->to, "v2");
    EXPECT_EQ(back->range_m, 12.5);
    EXPECT_EQ(back->device_time_ns, 123456789012345ULL);
    EXPECT_EQ(back->flags, 3);
    refuses_every_prefix(
        range_bytes, [&](auto bytes) { return decode_range(bytes, world.encoding).has_value(); });
  }
}

Bytes nodeframe(Encoding encoding, bool with_header, int floats, bool wide_ids) {
  ByteWriter out(encoding);
  if (with_header) {
    out.header(Time::from_ns(8'000'000'000), "uwb");
    out.put(std::int64_t{123});
  }
  out.put(std::uint8_t{2});
  if (wide_ids) {
    out.put(std::uint32_t{70'000});
  } else {
    out.put(std::uint8_t{5});
  }
  out.put(std::uint32_t{1000});
  out.put(std::uint32_t{2000});
  out.put(4.9F);
  for (int i = 0; i < floats; ++i) out.put(0.5F);
  out.sequence(2);
  for (const float range_m : {3.25F, 0.0F}) {
    out.put(std::uint8_t{2});
    if (wide_ids) {
      out.put(std::uint32_t{80'000});
    } else {
      out.put(std::uint8_t{7});
    }
    out.put(range_m);
    out.put(-80.0F);
    out.put(-78.5F);
  }
  return out.take();
}

TEST(Decode, linktrack_frames_give_ranges_and_count_zero_distances) {
  for (const Encoding encoding : {Encoding::kRos1, Encoding::kCdr}) {
    const auto frame3 = decode_linktrack("nlink_parser/LinktrackNodeframe3",
                                         nodeframe(encoding, false, 0, false), encoding);
    ASSERT_TRUE(frame3.has_value());
    EXPECT_EQ(frame3->id, 5U);
    EXPECT_EQ(frame3->local_time_ms, 1000U);
    ASSERT_EQ(frame3->nodes.size(), 1U);
    EXPECT_EQ(frame3->nodes[0].id, 7U);
    EXPECT_EQ(frame3->nodes[0].range_m, 3.25);
    EXPECT_EQ(frame3->nodes[0].rx_rssi_dbm, -78.5);
    EXPECT_EQ(frame3->zeros, 1U);
    const auto frame5 = decode_linktrack("nlink_parser_ros2_interfaces/msg/LinktrackNodeframe5",
                                         nodeframe(encoding, false, 0, true), encoding);
    ASSERT_TRUE(frame5.has_value());
    EXPECT_EQ(frame5->id, 70'000U);
    EXPECT_EQ(frame5->nodes[0].id, 80'000U);
  }
}

TEST(Decode, linktrack_nodeframe2_is_read_with_and_without_a_header) {
  for (const Encoding encoding : {Encoding::kRos1, Encoding::kCdr}) {
    for (const bool with_header : {false, true}) {
      const Bytes message = nodeframe(encoding, with_header, 22, false);
      const auto frame = decode_linktrack("nlink_parser/LinktrackNodeframe2", message, encoding);
      ASSERT_TRUE(frame.has_value());
      EXPECT_EQ(frame->id, 5U);
      EXPECT_EQ(frame->stamp.ns, with_header ? 8'000'000'000 : 0);
      ASSERT_EQ(frame->nodes.size(), 1U);
      EXPECT_EQ(frame->nodes[0].range_m, 3.25);
    }
  }
}

TEST(Decode, linktrack_tagframe0_has_eight_distances) {
  ByteWriter out(Encoding::kRos1);
  out.put(std::uint8_t{1});
  out.put(std::uint8_t{3});
  for (int i = 0; i < 2; ++i) out.put(std::uint32_t{10});
  for (int i = 0; i < 1 + 9; ++i) out.put(0.0F);
  for (int i = 0; i < 8; ++i) out.put(i == 6 ? 4.5F : 0.0F);
  for (int i = 0; i < 13; ++i) out.put(0.0F);
  const Bytes message = out.take();
  const auto frame = decode_linktrack("nlink_parser/LinktrackTagframe0", message, Encoding::kRos1);
  ASSERT_TRUE(frame.has_value());
  ASSERT_EQ(frame->nodes.size(), 1U);
  EXPECT_EQ(frame->nodes[0].id, 6U);
  EXPECT_EQ(frame->nodes[0].range_m, 4.5);
  EXPECT_EQ(frame->zeros, 7U);
  refuses_every_prefix(message, [&](auto bytes) {
    return decode_linktrack("nlink_parser/LinktrackTagframe0", bytes, Encoding::kRos1).has_value();
  });
}

}  // namespace
}  // namespace rali::wire
