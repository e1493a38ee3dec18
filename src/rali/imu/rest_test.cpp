#include "rali/imu/rest.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::imu {
namespace {

using geometry::Mat3;
using geometry::Vec3;
using sensor::ImuSample;

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<ImuSample> samples(int n, double gyro_sd, double accel_sd, const Vec3& gyro_mean) {
  Rng rng(1, "rest");
  std::vector<ImuSample> out;
  const auto noise = [&rng] { return Vec3(rng.normal(), rng.normal(), rng.normal()); };
  for (int k = 0; k < n; ++k) {
    out.push_back({Time::from_s(0.005 * k), gyro_mean + gyro_sd * noise(),
                   Vec3(0.0, 0.0, 9.81) + accel_sd * noise()});
  }
  return out;
}

// Test T5 of the design.
TEST(Rest, levels_a_tilted_sensor) {
  const Vec3 f(0.170, -0.340, 9.800);
  const Mat3 R = level(f);
  EXPECT_NEAR(f.norm(), 9.807370, 1e-6);
  EXPECT_LT((R * f - Vec3(0.0, 0.0, 9.80737)).norm(), 1e-5);
  const Vec3 turn = geometry::so3_log(R);
  EXPECT_LT((turn - Vec3(-0.034676, -0.017338, 0.0)).norm(), 1e-6);
  EXPECT_NEAR(turn.norm() / kDegree, 2.22133, 1e-5);
  const Vec3 rpy = geometry::rpy_from_rotation(R);
  EXPECT_NEAR(rpy.x() / kDegree, -1.98702, 1e-3);
  EXPECT_NEAR(rpy.y() / kDegree, -0.99321, 1e-3);
}

TEST(Rest, levels_a_sensor_mounted_upside_down) {
  const Mat3 R = level(Vec3(0.0, 0.0, -9.81));
  EXPECT_NEAR((R * Vec3(0.0, 0.0, -1.0)).z(), 1.0, 1e-12);
  EXPECT_LT((R * R.transpose() - Mat3::Identity()).norm(), 1e-12);
}

TEST(Rest, statistics_of_two_samples_match_hand_computed_values) {
  const std::vector<ImuSample> s{{Time{}, Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 9.0)},
                                 {Time{}, Vec3(3.0, 0.0, 0.0), Vec3(0.0, 0.0, 10.0)}};
  const ImuStatistics out = statistics(s);
  EXPECT_EQ(out.samples, 2);
  EXPECT_LT((out.gyro_mean_radps - Vec3(2.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((out.gyro_sd_radps - Vec3(1.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LT((out.accel_mean_mps2 - Vec3(0.0, 0.0, 9.5)).norm(), 1e-15);
  EXPECT_LT((out.accel_sd_mps2 - Vec3(0.0, 0.0, 0.5)).norm(), 1e-15);
}

TEST(Rest, is_detected_in_samples_at_standstill) {
  EXPECT_TRUE(is_rest(statistics(samples(200, 0.005, 0.05, Vec3(0.01, 0.0, 0.0))), {}));
}

TEST(Rest, is_not_detected_with_high_scatter_or_steady_rotation) {
  EXPECT_FALSE(is_rest(statistics(samples(200, 0.05, 0.05, Vec3::Zero())), {}));
  EXPECT_FALSE(is_rest(statistics(samples(200, 0.005, 0.5, Vec3::Zero())), {}));
  // A steady rotation has no standard deviation: only the mean reveals it.
  EXPECT_FALSE(is_rest(statistics(samples(200, 0.005, 0.05, Vec3(0.0, 0.0, 0.2))), {}));
}

TEST(Rest, is_not_detected_in_too_few_or_nan_samples) {
  EXPECT_FALSE(is_rest(statistics({}), {}));
  EXPECT_FALSE(is_rest(statistics(samples(9, 0.0, 0.0, Vec3::Zero())), {}));
  std::vector<ImuSample> broken = samples(200, 0.005, 0.05, Vec3::Zero());
  broken[100].gyro_radps.y() = std::nan("");
  EXPECT_FALSE(is_rest(statistics(broken), {}));
  broken = samples(200, 0.005, 0.05, Vec3::Zero());
  broken[100].accel_mps2.z() = std::nan("");
  EXPECT_FALSE(is_rest(statistics(broken), {}));
}

}  // namespace
}  // namespace rali::imu
