#include "rali/odometry/robust/stillness.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

TEST(BlockMeans, average_tenths_of_a_second) {
  std::vector<sensor::ImuSample> samples;
  for (int k = 0; k < 50; ++k) {
    samples.push_back(
        {Time::from_s(0.005 * k), geometry::Vec3(k, 0.0, 0.0), geometry::Vec3::Zero()});
  }
  const auto blocks = block_means(samples);
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_DOUBLE_EQ(blocks[0].gyro_radps.x(), 9.5);
  EXPECT_DOUBLE_EQ(blocks[1].gyro_radps.x(), 29.5);
  EXPECT_DOUBLE_EQ(blocks[2].gyro_radps.x(), 44.5);
  EXPECT_TRUE(block_means({}).empty());
  samples.resize(42);  // two left over: as noisy as samples are
  EXPECT_EQ(block_means(samples).size(), 2U);
  samples.resize(2);
  EXPECT_EQ(block_means(samples).size(), 1U);
}

TEST(Quiet, is_asked_axis_by_axis_and_never_of_nan) {
  imu::ImuStatistics blocks;
  blocks.gyro_sd_radps = Vec3(0.01, 0.01, 0.01);
  blocks.accel_sd_mps2 = Vec3(0.1, 0.1, 0.1);
  EXPECT_TRUE(is_quiet(blocks, {}));
  imu::ImuStatistics shaken = blocks;
  shaken.accel_sd_mps2.y() = 0.3;
  EXPECT_FALSE(is_quiet(shaken, {}));
  imu::ImuStatistics broken = blocks;
  broken.gyro_sd_radps.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_quiet(broken, {}));
}

TEST(Travel, counts_only_where_the_lidar_knows) {
  Mat3 blind_along_x = 1e-6 * Mat3::Identity();
  blind_along_x(0, 0) = 0.8;
  EXPECT_FALSE(has_travelled(Vec3(2.4, 0.0, 0.0), blind_along_x, 0.1));
  EXPECT_TRUE(has_travelled(Vec3(2.8, 0.0, 0.0), blind_along_x, 0.1));
  EXPECT_TRUE(has_travelled(Vec3(0.0, 0.11, 0.0), blind_along_x, 0.1));
  EXPECT_FALSE(has_travelled(Vec3(0.0, 0.09, 0.0), blind_along_x, 0.1));
  EXPECT_TRUE(
      has_travelled(Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0), blind_along_x, 0.1));
}

}  // namespace
}  // namespace rali::odometry
