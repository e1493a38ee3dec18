#include "rali/odometry/robust/stillness.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

TEST(BlockMeans, average_samples_over_0_1_s) {
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
  samples.resize(42);  // two left over: with the noise of single samples
  EXPECT_EQ(block_means(samples).size(), 2U);
  samples.resize(2);
  EXPECT_EQ(block_means(samples).size(), 1U);
}

TEST(Shaking, is_the_spread_without_turns_and_changes_of_speed) {
  Rng rng(3, "shaking");
  std::vector<sensor::ImuSample> samples;
  const auto fill = [&](double slow, double noise) {
    samples.clear();
    for (int k = 0; k < 2000; ++k) {
      const double t_s = 0.005 * k;
      const Vec3 white(rng.normal(), rng.normal(), rng.normal());
      const Vec3 sway(slow * std::sin(3.0 * t_s), slow * std::cos(3.0 * t_s), 9.81);
      samples.push_back({Time::from_s(t_s), 0.1 * (sway + noise * white), sway + noise * white});
    }
    return shaking(samples);
  };
  const Shaking still = fill(0.0, 0.02);
  EXPECT_NEAR(still.accel_mps2, 0.02 * std::sqrt(3.0), 0.002);
  EXPECT_NEAR(still.gyro_radps, 0.002 * std::sqrt(3.0), 0.0002);
  EXPECT_NEAR(fill(1.0, 0.02).accel_mps2, still.accel_mps2, 0.005) << "it accelerates and turns";
  EXPECT_NEAR(fill(1.0, 0.2).accel_mps2, 0.2 * std::sqrt(3.0), 0.02) << "it shakes";
  EXPECT_EQ(shaking({}).accel_mps2, 0.0);
}

TEST(Quiet, is_tested_per_axis_and_false_for_nan) {
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

/// 15 s of block means: white noise, and a sway at `hz`.
std::vector<sensor::ImuSample> swaying(std::uint64_t seed, double hz, double gyro_radps) {
  constexpr double kGyro_radps = 0.003, kAccel_mps2 = 0.05;
  Rng rng(seed, "blocks");
  std::vector<sensor::ImuSample> blocks;
  for (int k = 0; k < 150; ++k) {
    sensor::ImuSample s{Time::from_s(0.1 * k), Vec3::Zero(), Vec3(0.0, 0.0, 9.81)};
    for (int i = 0; i < 3; ++i) {
      s.gyro_radps[i] = kGyro_radps * rng.normal();
      s.accel_mps2[i] += kAccel_mps2 * rng.normal();
    }
    s.gyro_radps.z() += gyro_radps * std::sin(6.28 * hz * 0.1 * k);
    blocks.push_back(s);
  }
  return blocks;
}

TEST(OnlyNoise, is_detected_for_white_noise_but_not_for_slow_steering) {
  int still = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    still += is_only_noise(swaying(seed, 0.0, 0.0)) ? 1 : 0;
    EXPECT_FALSE(is_only_noise(swaying(seed, 0.1, 0.006))) << seed;
  }
  EXPECT_GE(still, 390);
}

TEST(OnlyNoise, is_not_detected_with_few_constant_or_nan_samples) {
  std::vector<sensor::ImuSample> blocks = swaying(1, 0.0, 0.0);
  EXPECT_TRUE(is_only_noise(blocks));
  EXPECT_FALSE(is_only_noise(std::span(blocks).first(99)));
  std::vector<sensor::ImuSample> silent = blocks;
  for (sensor::ImuSample& s : silent) s.gyro_radps.x() = 0.0;
  EXPECT_FALSE(is_only_noise(silent));
  blocks[7].accel_mps2.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_only_noise(blocks));
}

/// 2 s at 200 Hz: an engine at 27 Hz, noise, and motion at `hz`.
std::vector<sensor::ImuSample> shaken(std::uint64_t seed, double engine, double noise, double hz,
                                      double motion) {
  Rng rng(seed, "shaken");
  std::vector<sensor::ImuSample> samples;
  for (int k = 0; k < 400; ++k) {
    const double t_s = 0.005 * k;
    sensor::ImuSample s{Time::from_s(t_s), Vec3::Zero(), Vec3(0.0, 0.0, 9.81)};
    for (int i = 0; i < 3; ++i) {
      const double shake = engine * std::sin(6.28 * 27.3 * t_s + i);
      const double move = motion * std::sin(6.28 * hz * t_s + i);
      s.gyro_radps[i] = 0.05 * (shake + noise * rng.normal() + move);
      s.accel_mps2[i] += shake + noise * rng.normal() + move;
    }
    samples.push_back(s);
  }
  return samples;
}

TEST(Idling, is_a_tone_or_noise_without_slower_motion) {
  int engine = 0, noise = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    engine += is_idling(shaken(seed, 1.0, 0.03, 1.0, 0.0)) ? 1 : 0;
    noise += is_idling(shaken(seed, 0.0, 0.5, 1.0, 0.0)) ? 1 : 0;
    EXPECT_FALSE(is_idling(shaken(seed, 1.0, 0.03, 1.6, 0.5))) << "a suspension, seed " << seed;
    EXPECT_FALSE(is_idling(shaken(seed, 0.5, 0.03, 0.3, 0.3))) << "an uneven floor, seed " << seed;
  }
  EXPECT_EQ(engine, 100);
  EXPECT_GE(noise, 60);  // F of few samples
}

TEST(Idling, is_not_claimed_of_short_constant_or_nan_samples) {
  std::vector<sensor::ImuSample> samples = shaken(1, 1.0, 0.03, 1.0, 0.0);
  EXPECT_TRUE(is_idling(samples));
  EXPECT_FALSE(is_idling({samples.begin(), samples.begin() + 300}));
  EXPECT_FALSE(is_idling({}));
  std::vector<sensor::ImuSample> silent = samples;
  for (sensor::ImuSample& s : silent) s.gyro_radps.x() = 0.0;
  EXPECT_FALSE(is_idling(silent));
  samples[7].accel_mps2.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_idling(samples));
}

TEST(Travel, counts_beyond_the_distance_limit_and_3_sigma_of_the_lidar) {
  Mat3 degenerate_along_x = 1e-6 * Mat3::Identity();
  degenerate_along_x(0, 0) = 0.8;
  EXPECT_FALSE(has_travelled(Vec3(2.4, 0.0, 0.0), degenerate_along_x, 0.1));
  EXPECT_TRUE(has_travelled(Vec3(2.8, 0.0, 0.0), degenerate_along_x, 0.1));
  EXPECT_TRUE(has_travelled(Vec3(0.0, 0.11, 0.0), degenerate_along_x, 0.1));
  EXPECT_FALSE(has_travelled(Vec3(0.0, 0.09, 0.0), degenerate_along_x, 0.1));
  EXPECT_TRUE(has_travelled(Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0),
                            degenerate_along_x, 0.1));
}

TEST(Turn, counts_beyond_0_01_rad_and_3_sigma_of_the_lidar) {
  EXPECT_FALSE(has_turned(-0.009, 0.0));
  EXPECT_TRUE(has_turned(-0.011, 0.0));
  EXPECT_FALSE(has_turned(0.029, 1e-4));  // 3 sigma are 0.03
  EXPECT_TRUE(has_turned(0.033, 1e-4));
  EXPECT_TRUE(has_turned(std::numeric_limits<double>::quiet_NaN(), 1e-4));
}

}  // namespace
}  // namespace rali::odometry
