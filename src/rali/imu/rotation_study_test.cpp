#include "rali/imu/rotation_study.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/imu/turning_for_test.hpp"

namespace rali::imu {
namespace {

using test::TurningPair;

constexpr double kDeg = std::numbers::pi / 180.0;

TEST(GyroTrack, a_constant_rate_gives_rate_times_time) {
  std::vector<sensor::ImuSample> samples;
  for (int i = 0; i <= 100; ++i) {
    samples.push_back({Time::from_s(0.01 * i), {0.0, 0.0, 0.5}, geometry::Vec3::Zero()});
  }
  const GyroTrack track(samples);
  const auto turn = track.turn(Time::from_s(0.123), Time::from_s(0.523));
  ASSERT_TRUE(turn.has_value());
  EXPECT_NEAR(turn->z(), 0.2, 1e-9);
  EXPECT_FALSE(track.turn(Time::from_s(-0.1), Time::from_s(0.5)).has_value());
  EXPECT_FALSE(track.turn(Time::from_s(0.5), Time::from_s(1.1)).has_value());
}

TEST(GyroTrack, gives_no_rotation_across_a_gap) {
  std::vector<sensor::ImuSample> samples;
  for (int i = 0; i <= 100; ++i) {
    if (i < 40 || i > 60)
      samples.push_back({Time::from_s(0.01 * i), {0.0, 0.0, 0.5}, geometry::Vec3::Zero()});
  }
  const GyroTrack track(samples);
  EXPECT_FALSE(track.turn(Time::from_s(0.3), Time::from_s(0.7)).has_value());
  EXPECT_TRUE(track.turn(Time::from_s(0.1), Time::from_s(0.2)).has_value());
}

TEST(RotationStudy, finds_an_offset_of_38_ms_within_its_own_sigma) {
  TurningPair pair;
  pair.lidar_late_s = -0.038;  // stamps are too early: 38 ms must be added
  const auto study = study_rotations(pair.lidar(), pair.imu());
  ASSERT_TRUE(study.time_offset_s.has_value());
  EXPECT_NEAR(*study.time_offset_s, 0.038, 0.002);
  EXPECT_LT(std::abs(*study.time_offset_s - 0.038), 4.0 * study.time_offset_sigma_s);
  EXPECT_LT(study.time_offset_sigma_s, 0.003);
  EXPECT_NEAR(study.gyro_ratio, 1.0, 0.02);
}

TEST(RotationStudy, reports_zero_offset_for_synchronised_sensors) {
  const TurningPair pair;
  const auto study = study_rotations(pair.lidar(), pair.imu());
  ASSERT_TRUE(study.time_offset_s.has_value());
  EXPECT_NEAR(*study.time_offset_s, 0.0, 0.002);
}

// A nearly degenerate LiDAR odometry lags for three seconds of strong turning.
TEST(RotationStudy, a_lidar_lag_in_one_turn_is_not_a_time_offset) {
  TurningPair pair;
  pair.duration_s = 40.0;
  pair.rate_radps = 0.15;
  std::vector<LidarTurn> lidar = pair.lidar();
  const auto strong = [](double t_s) { return std::abs(t_s - 20.0) < 1.5 ? 0.8 : 0.0; };
  std::vector<sensor::ImuSample> imu = pair.imu();
  for (sensor::ImuSample& sample : imu) sample.gyro_radps.z() += strong(sample.t.s());
  for (LidarTurn& turn : lidar) {
    turn.turn_lidar_rad.z() += 0.1 * strong(0.5 * (turn.begin.s() + turn.end.s()) - 0.2);
  }
  const auto study = study_rotations(lidar, imu);
  EXPECT_FALSE(study.time_offset_s && std::abs(*study.time_offset_s) > 0.02)
      << *study.time_offset_s << " +- " << study.time_offset_sigma_s;
  EXPECT_GT(study.time_offset_sigma_s, 0.01);
}

TEST(RotationStudy, a_vehicle_that_never_turns_gives_no_offset) {
  TurningPair pair;
  pair.rate_radps = 0.0;
  const auto study = study_rotations(pair.lidar(), pair.imu());
  EXPECT_FALSE(study.time_offset_s.has_value());
  EXPECT_EQ(study.gyro_ratio, 0.0);
}

TEST(RotationStudy, degrees_per_second_show_as_a_ratio_of_57) {
  TurningPair pair;
  pair.gyro_scale = 180.0 / std::numbers::pi;
  const auto study = study_rotations(pair.lidar(), pair.imu());
  EXPECT_NEAR(study.gyro_ratio, 57.3, 1.5);
}

TEST(RotationStudy, finds_the_rotation_between_the_sensors) {
  TurningPair pair;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.1, -0.2, 1.3);
  const auto study = study_rotations(pair.lidar(), pair.imu());
  const double error =
      geometry::so3_log(study.best.R_imu_lidar.transpose() * pair.R_imu_lidar).norm();
  EXPECT_LT(error, 1.0 * kDeg);
  EXPECT_GT(study.second_axis_fraction, 0.2);
  EXPECT_LT(study.best.misfit, 0.1);
  const double inverse = misfit_of(pair.R_imu_lidar.transpose(), pair.lidar(), pair.imu(), study);
  EXPECT_GT(inverse, 5.0 * study.best.misfit);
}

TEST(RotationStudy, a_gyro_bias_does_not_rotate_the_extrinsic_estimate) {
  TurningPair pair;
  pair.gyro_bias_radps = {0.02, -0.03, 0.01};
  const auto study = study_rotations(pair.lidar(), pair.imu());
  EXPECT_LT(geometry::so3_log(study.best.R_imu_lidar).norm(), 1.0 * kDeg);
}

TEST(RotationStudy, a_mirrored_y_axis_is_estimated_as_180_degrees_about_y) {
  TurningPair pair;
  pair.mirrored_y = true;
  const geometry::Mat3 R = study_rotations(pair.lidar(), pair.imu()).best.R_imu_lidar;
  EXPECT_NEAR(R(0, 0), -1.0, 0.001);
  EXPECT_NEAR(R(1, 1), 1.0, 0.001);
  EXPECT_NEAR(R(2, 2), -1.0, 0.001);
}

TEST(RotationStudy, empty_or_nan_input_gives_no_time_offset) {
  EXPECT_FALSE(study_rotations({}, {}).time_offset_s.has_value());
  TurningPair pair;
  auto lidar = pair.lidar();
  auto imu = pair.imu();
  for (LidarTurn& turn : lidar) turn.turn_lidar_rad.x() = std::nan("");
  EXPECT_FALSE(study_rotations(lidar, imu).time_offset_s.has_value());
  for (auto& sample : imu) sample.gyro_radps.x() = std::nan("");
  EXPECT_FALSE(study_rotations(pair.lidar(), imu).time_offset_s.has_value());
}

/// A pitch of 7 Hz that the LiDAR reports 40 ms late, as if a scan measured the front early.
TEST(RotationStudy, vibration_measured_late_by_the_lidar_is_not_a_time_offset) {
  TurningPair pair;
  const auto shake = [](double t_s) {
    return 0.004 * std::sin(2.0 * std::numbers::pi * 7.3 * t_s);
  };
  std::vector<LidarTurn> lidar = pair.lidar();
  for (LidarTurn& turn : lidar) {
    turn.turn_lidar_rad.y() += shake(turn.end.s() - 0.04) - shake(turn.begin.s() - 0.04);
  }
  std::vector<sensor::ImuSample> imu = pair.imu();
  for (sensor::ImuSample& sample : imu) {
    const double t = sample.t.s();
    sample.gyro_radps.y() += (shake(t + 1e-4) - shake(t - 1e-4)) / 2e-4;
  }
  const auto study = study_rotations(lidar, imu);
  ASSERT_TRUE(study.time_offset_s.has_value());
  EXPECT_NEAR(*study.time_offset_s, 0.0, 0.002);
  EXPECT_NEAR(study.gyro_ratio, 1.0, 0.02);
}

TEST(RotationStudy, noise_of_the_lidar_widens_the_bounds_of_the_gyro_ratio_about_the_truth) {
  TurningPair pair;
  pair.tilt_radps = 0.0;
  const auto exact = study_rotations(pair.lidar(), pair.imu());
  EXPECT_NEAR(exact.gyro_ratio_max, exact.gyro_ratio, 0.02);
  // The yaw rate 0.6 sin 0.7 t + 0.18 sin 2.3 t, each averaged over two windows of a second.
  EXPECT_NEAR(exact.gyro_rate_rms, 0.40, 0.03);
  auto noisy = pair.lidar();
  Rng rng(3, "noise");
  for (LidarTurn& turn : noisy) {
    turn.turn_lidar_rad += 0.08 * geometry::Vec3(rng.normal(), rng.normal(), rng.normal());
  }
  const auto study = study_rotations(noisy, pair.imu());
  ASSERT_GT(study.gyro_ratio, 0.0);
  EXPECT_LT(study.gyro_ratio, 0.97);
  EXPECT_GT(study.gyro_ratio_max, 1.0);
}

TEST(RotationStudy, the_gyro_that_does_not_turn_shows_beside_a_noisy_lidar) {
  TurningPair pair;
  pair.rate_radps = 0.0;
  auto noisy = pair.lidar();
  Rng rng(3, "noise");
  for (LidarTurn& turn : noisy) {
    turn.turn_lidar_rad += 0.02 * geometry::Vec3(rng.normal(), rng.normal(), rng.normal());
  }
  const auto study = study_rotations(noisy, pair.imu());
  EXPECT_GT(study.turn_rate_rms, 0.1);
  EXPECT_LT(study.gyro_rate_rms, 0.01);
}

TEST(RotationStudy, slow_turning_keeps_the_gyro_ratio_near_one) {
  TurningPair pair;
  pair.rate_radps = 0.03;
  pair.tilt_radps = 0.0;
  const auto study = study_rotations(pair.lidar(), pair.imu());
  EXPECT_NEAR(study.gyro_ratio, 1.0, 0.1);
  EXPECT_LT(study.best.misfit, 1.0) << "of the unit that was chosen";
}

}  // namespace
}  // namespace rali::imu
