#include <cstring>

#include <gtest/gtest.h>

#include "rali/wire/byte_reader.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/encode.hpp"

namespace rali::wire {
namespace {

double double_at(const Bytes& bytes, std::size_t at) {
  double value = 0.0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

std::uint32_t u32_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

TEST(EncodeNav, odometry_has_the_byte_layout_of_ros_2) {
  Odometry odometry;
  odometry.stamp = Time::from_ns(1'500'000'000);
  odometry.frame_id = "odo";        // with its zero 4 bytes
  odometry.child_frame_id = "bas";  // the same
  odometry.T_frame_child.p = {1.0, 2.0, 3.0};
  odometry.pose_covariance(0, 5) = 0.25;
  odometry.v_child_mps = {4.0, 0.0, 0.0};
  const Bytes bytes = encode(odometry, Encoding::kCdr);
  // Encapsulation 4; from there: time 8, strings 8 each, three doubles, quaternion, 36, 6, 36.
  constexpr std::size_t kBody = 4, kPose = kBody + 24, kCovariance = kPose + 56;
  constexpr std::size_t kTwist = kCovariance + 36 * 8;
  ASSERT_EQ(bytes.size(), kTwist + (6 + 36) * 8);
  EXPECT_EQ(u32_at(bytes, kBody), 1U);
  EXPECT_EQ(u32_at(bytes, kBody + 4), 500'000'000U);
  EXPECT_EQ(double_at(bytes, kPose + 8), 2.0);
  EXPECT_EQ(double_at(bytes, kPose + 48), 1.0);  // w
  EXPECT_EQ(double_at(bytes, kCovariance + 5 * 8), 0.25);
  EXPECT_EQ(double_at(bytes, kTwist), 4.0);
}

TEST(EncodeNav, odometry_survives_a_round_trip) {
  Odometry odometry;
  odometry.stamp = Time::from_ns(1'500'000'000);
  odometry.frame_id = "v1/odom";
  odometry.child_frame_id = "v1/base_link";
  odometry.T_frame_child.p = {1.0, 2.0, 3.0};
  odometry.T_frame_child.R << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  odometry.pose_covariance(0, 5) = 0.25;
  odometry.omega_child_radps = {0.0, 0.0, 0.5};
  const Bytes bytes = encode(odometry, Encoding::kCdr);
  const auto read = decode_odometry(bytes, Encoding::kCdr);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->stamp, odometry.stamp);
  EXPECT_EQ(read->frame_id, odometry.frame_id);
  EXPECT_EQ(read->child_frame_id, odometry.child_frame_id);
  EXPECT_EQ(read->T_frame_child.p, odometry.T_frame_child.p);
  EXPECT_TRUE(read->T_frame_child.R.isApprox(odometry.T_frame_child.R, 1e-12));
  EXPECT_EQ(read->pose_covariance, odometry.pose_covariance);
  EXPECT_EQ(read->omega_child_radps, odometry.omega_child_radps);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    EXPECT_FALSE(decode_odometry(std::span(bytes).first(size), Encoding::kCdr)) << size;
  }
}

TEST(EncodeNav, occupancy_grid_has_the_byte_layout_of_ros_2) {
  GridMessage grid;
  grid.frame_id = "map";
  grid.cell_m = 0.2F;
  grid.width = 2;
  grid.height = 1;
  grid.origin_m = {-1.0, 5.0};
  grid.cells = {-1, 100};
  const Bytes bytes = encode(grid, Encoding::kCdr);
  // Time 8, string 8, load time 8, cell 4, width 4, height 4, to a multiple of 8, seven doubles.
  constexpr std::size_t kBody = 4, kOrigin = kBody + 40;
  ASSERT_EQ(bytes.size(), kOrigin + 7 * 8 + 4 + 2);
  EXPECT_EQ(u32_at(bytes, kBody + 28), 2U);
  EXPECT_EQ(u32_at(bytes, kBody + 32), 1U);
  EXPECT_EQ(double_at(bytes, kOrigin), -1.0);
  EXPECT_EQ(double_at(bytes, kOrigin + 8), 5.0);
  EXPECT_EQ(u32_at(bytes, kOrigin + 56), 2U);
  EXPECT_EQ(static_cast<std::int8_t>(bytes[kOrigin + 60]), -1);
  EXPECT_EQ(static_cast<std::int8_t>(bytes[kOrigin + 61]), 100);
}

}  // namespace
}  // namespace rali::wire
