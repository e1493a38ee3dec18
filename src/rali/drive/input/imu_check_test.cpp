#include "rali/drive/input/imu_check.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/input/imu_intake.hpp"

namespace rali::drive {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

/// Two seconds at 200 Hz in the units asked for.
std::vector<sensor::ImuSample> at_rest(double accel, double gyro_bias, double gyro_noise) {
  Rng rng(1);
  std::vector<sensor::ImuSample> samples;
  for (int i = 0; i < 400; ++i) {
    sensor::ImuSample s;
    s.t = Time::from_s(10.0 + 0.005 * i);
    s.accel_mps2 = {0.002 * accel * rng.normal(), 0.002 * accel * rng.normal(), accel};
    s.gyro_radps = {gyro_bias + gyro_noise * rng.normal(), gyro_noise * rng.normal(), 0.0};
    samples.push_back(s);
  }
  return samples;
}

TEST(ImuUnits, leaves_si_units_alone) {
  const auto units = decide_imu_units(at_rest(9.81, 0.005, 0.002), {}, "/imu");
  ASSERT_TRUE(units);
  EXPECT_EQ(units->accel_scale, 1.0);
  EXPECT_EQ(units->gyro_scale, 1.0);
  EXPECT_TRUE(units->findings.empty());
}

TEST(ImuUnits, recognises_g_and_scales_by_the_measured_length) {
  const auto units = decide_imu_units(at_rest(0.99, 0.005, 0.002), {}, "/livox/imu");
  ASSERT_TRUE(units);
  EXPECT_NEAR(0.99 * units->accel_scale, 9.80665, 0.02);
  ASSERT_EQ(units->findings.size(), 1U);
  EXPECT_EQ(units->findings[0].id, "D08");
}

TEST(ImuUnits, refuses_data_without_gravity) {
  const auto units = decide_imu_units(at_rest(0.03, 0.005, 0.002), {}, "/imu");
  ASSERT_FALSE(units);
  EXPECT_EQ(units.error().code, ErrorCode::kInput);
  EXPECT_NE(units.error().what.find("gravity was removed"), std::string::npos);
}

TEST(ImuUnits, recognises_degrees_by_bias_and_by_noise_at_rest) {
  for (const auto& [bias, noise] : {std::pair{0.4, 0.02}, std::pair{0.01, 0.1}}) {
    const auto units = decide_imu_units(at_rest(9.81, bias, noise), {}, "/imu");
    ASSERT_TRUE(units);
    EXPECT_NEAR(units->gyro_scale, kDeg, 1e-12);
    EXPECT_EQ(units->findings.at(0).id, "D09");
  }
}

TEST(ImuUnits, obeys_the_settings) {
  InputOptions options;
  options.accel_unit = AccelUnit::kMps2;
  options.gyro_unit = GyroUnit::kRadps;
  const auto units = decide_imu_units(at_rest(0.99, 0.4, 0.1), options, "/imu");
  ASSERT_TRUE(units);
  EXPECT_EQ(units->accel_scale, 1.0);
  EXPECT_EQ(units->gyro_scale, 1.0);
}

TEST(ImuIntake, turns_samples_into_the_body_and_takes_the_centripetal_part_off) {
  geometry::SE3 T_body_imu;
  T_body_imu.R = geometry::rotation_from_rpy(0.0, 0.0, std::numbers::pi / 2.0);
  T_body_imu.p = {0.5, 0.0, 0.0};
  ImuIntake intake({}, T_body_imu);
  sensor::ImuSample raw;
  raw.gyro_radps = {0.0, 0.0, 2.0};
  // x of the IMU is y of the body. Turning at 2 rad/s, 0.5 m ahead: -2 m/s2 along body x.
  raw.accel_mps2 = {0.0, 2.0, 9.81};
  InputGaps gaps;
  const auto body = intake.take(raw, gaps);
  ASSERT_TRUE(body);
  EXPECT_NEAR(body->accel_mps2.x(), 0.0, 1e-12);
  EXPECT_NEAR(body->accel_mps2.y(), 0.0, 1e-12);
  EXPECT_NEAR(body->accel_mps2.z(), 9.81, 1e-12);
}

TEST(ImuIntake, counts_and_drops_what_is_no_number) {
  ImuIntake intake({}, {});
  InputGaps gaps;
  sensor::ImuSample raw;
  raw.accel_mps2 = {0.0, std::nan(""), 9.81};
  EXPECT_FALSE(intake.take(raw, gaps));
  raw.accel_mps2 = {0.0, HUGE_VAL, 9.81};
  EXPECT_FALSE(intake.take(raw, gaps));
  EXPECT_EQ(gaps.imu_invalid, 2U);
}

TEST(ImuIntake, counts_values_that_stay_at_their_largest) {
  ImuIntake intake({}, {});
  InputGaps gaps;
  for (const double a : {9.0, 39.2, 39.2, 39.2, 12.0}) {
    sensor::ImuSample raw;
    raw.accel_mps2 = {a, 0.0, 9.81};
    ASSERT_TRUE(intake.take(raw, gaps));
  }
  EXPECT_EQ(gaps.imu_saturated, 2U);
}

TEST(GyroRatio, says_nothing_before_something_was_turned) {
  GyroRatio ratio;
  ratio.add_gyro(0.1);
  ratio.add_lidar(0.1);
  EXPECT_EQ(ratio.ratio(), 0.0);
  ratio.add_gyro(22.9);
  ratio.add_lidar(0.3);
  EXPECT_NEAR(ratio.ratio(), 57.5, 1e-9);
}

}  // namespace
}  // namespace rali::drive
