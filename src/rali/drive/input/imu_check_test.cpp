#include "rali/drive/input/imu_check.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/input/imu_intake.hpp"

namespace rali::drive {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

/// Two seconds at 200 Hz in the given units.
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

TEST(ImuUnits, recognises_degrees_per_second_by_bias_or_noise_at_standstill) {
  for (const auto& [bias, noise] :
       {std::pair{2.5, 0.02}, std::pair{0.4, 0.1}, std::pair{0.01, 0.6}}) {
    const auto units = decide_imu_units(at_rest(9.81, bias, noise), {}, "/imu");
    ASSERT_TRUE(units);
    EXPECT_NEAR(units->gyro_scale, kDeg, 1e-12);
    EXPECT_EQ(units->findings.at(0).id, "D09");
  }
}

/// Two seconds that start straight and end in a turn, sensed by the gyro only.
std::vector<sensor::ImuSample> smooth_bend(double rate_radps) {
  std::vector<sensor::ImuSample> samples = at_rest(9.81, 0.005, 0.003);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t_s = 0.005 * static_cast<double>(i);
    samples[i].gyro_radps.z() += rate_radps * std::min(1.0, 0.5 * t_s);
  }
  return samples;
}

TEST(ImuUnits, does_not_mistake_a_smooth_curve_for_standstill) {
  EXPECT_TRUE(quietest_stretch(at_rest(9.81, 0.005, 0.003)).at_rest);
  EXPECT_FALSE(quietest_stretch(smooth_bend(0.6)).at_rest);
  const auto units = decide_imu_units(smooth_bend(0.6), {}, "/imu");
  ASSERT_TRUE(units);
  EXPECT_EQ(units->gyro_scale, 1.0);
  EXPECT_TRUE(units->findings.empty());
}

TEST(ImuUnits, prefers_standstill_to_a_quieter_accelerometer_in_a_curve) {
  std::vector<sensor::ImuSample> samples = smooth_bend(0.6);
  for (std::size_t i = 0; i < 120; ++i) samples[i].gyro_radps.z() = 0.0;  // standstill for 0.6 s
  for (std::size_t i = 120; i < samples.size(); ++i) samples[i].accel_mps2 = {0.0, 0.0, 9.81};
  const ImuStretch quiet = quietest_stretch(samples);
  EXPECT_TRUE(quiet.at_rest);
  EXPECT_EQ(quiet.t_start, samples.front().t);
}

TEST(ImuUnits, keeps_radians_for_a_steady_rate_and_reports_a_finding) {
  const auto units = decide_imu_units(at_rest(9.81, 0.4, 0.003), {}, "/imu");
  ASSERT_TRUE(units);
  EXPECT_EQ(units->gyro_scale, 1.0);
  ASSERT_EQ(units->findings.size(), 1U);
  EXPECT_EQ(units->findings[0].id, "D09");
  EXPECT_NE(units->findings[0].remedy.find("gyro_unit"), std::string::npos);
}

TEST(ImuUnits, configured_units_override_the_detection) {
  InputOptions options;
  options.accel_unit = AccelUnit::kMps2;
  options.gyro_unit = GyroUnit::kRadps;
  const auto units = decide_imu_units(at_rest(0.99, 0.4, 0.1), options, "/imu");
  ASSERT_TRUE(units);
  EXPECT_EQ(units->accel_scale, 1.0);
  EXPECT_EQ(units->gyro_scale, 1.0);
}

TEST(ImuIntake, scales_to_si_units_and_keeps_the_frame_of_the_imu) {
  ImuUnits units;
  units.accel_scale = 9.8;
  units.gyro_scale = kDeg;
  ImuIntake intake(units);
  sensor::ImuSample raw;
  raw.t = Time::from_s(3.0);
  raw.gyro_radps = {0.0, 90.0, 0.0};
  raw.accel_mps2 = {0.5, 0.0, -1.0};
  InputGaps gaps;
  const auto si = intake.take(raw, gaps);
  ASSERT_TRUE(si);
  EXPECT_EQ(si->t, raw.t);
  EXPECT_NEAR((si->gyro_radps - geometry::Vec3(0.0, std::numbers::pi / 2.0, 0.0)).norm(), 0.0,
              1e-12);
  EXPECT_NEAR((si->accel_mps2 - geometry::Vec3(4.9, 0.0, -9.8)).norm(), 0.0, 1e-12);
}

TEST(ImuIntake, drops_and_counts_nan_and_infinite_samples) {
  ImuIntake intake({});
  InputGaps gaps;
  sensor::ImuSample raw;
  raw.accel_mps2 = {0.0, std::nan(""), 9.81};
  EXPECT_FALSE(intake.take(raw, gaps));
  raw.accel_mps2 = {0.0, HUGE_VAL, 9.81};
  EXPECT_FALSE(intake.take(raw, gaps));
  EXPECT_EQ(gaps.imu_invalid, 2U);
}

TEST(ImuIntake, counts_saturated_accelerometer_values) {
  ImuIntake intake({});
  InputGaps gaps;
  for (const double a : {9.0, 39.2, 39.2, 39.2, 12.0}) {
    sensor::ImuSample raw;
    raw.accel_mps2 = {a, 0.0, 9.81};
    ASSERT_TRUE(intake.take(raw, gaps));
  }
  EXPECT_EQ(gaps.imu_saturated, 2U);
}

TEST(GyroRatio, is_zero_before_enough_rotation) {
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
