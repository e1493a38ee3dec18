#include "rali/odometry/paper/inertial_guess.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/paper/testing/synthetic_room.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::SE3;
using geometry::Vec3;
using Start = InertialGuess::Start;

void feed(InertialGuess& guess, double start_s, double end_s, const Vec3& accel,
          const Vec3& gyro = Vec3::Zero()) {
  const auto first = static_cast<int>(std::lround(start_s * 200.0));
  const auto last = static_cast<int>(std::lround(end_s * 200.0));
  for (int k = first; k <= last; ++k) guess.add({Time::from_s(k * 0.005), gyro, accel});
}

InertialGuess fresh(const SE3& T_body_imu = {}) {
  return {ImuNoiseSettings{}, T_body_imu, 0.5, 0.0};
}

// Test T5 of the design.
TEST(InertialGuess, levels_at_standstill_as_computed_by_hand) {
  InertialGuess guess = fresh();
  FindingList findings;
  const Vec3 gyro(0.003, -0.002, 0.004);
  feed(guess, 0.0, 1.0, Vec3(0.170, -0.340, 9.800), gyro);
  ASSERT_EQ(guess.try_start(Time::from_s(1.0), findings), Start::kAtRest);
  const Vec3 log = geometry::so3_log(guess.T_odom_body().R);
  EXPECT_LT((log - Vec3(-0.034676, -0.017338, 0.0)).norm(), 1e-6);
  EXPECT_LT((guess.bias().gyro_radps - gyro).norm(), 1e-12);
  // |f| = 9.807370: the observable part of the accelerometer's bias.
  EXPECT_NEAR(guess.bias().accel_mps2.norm(), 9.81 - 9.807370, 1e-6);
  EXPECT_TRUE(findings.empty());
}

TEST(InertialGuess, waits_for_1_s_of_standstill_but_not_in_motion) {
  InertialGuess still = fresh();
  FindingList findings;
  EXPECT_EQ(still.try_start(Time::from_s(0.0), findings), Start::kWait);
  feed(still, 0.0, 0.7, Vec3(0.0, 0.0, 9.81));
  EXPECT_EQ(still.try_start(Time::from_s(0.7), findings), Start::kWait);
  InertialGuess moving = fresh();
  for (int k = 0; k <= 140; ++k) {
    const double t_s = 0.005 * k;
    moving.add({Time::from_s(t_s), Vec3(0.0, 0.0, std::sin(6.0 * t_s)), Vec3(0.0, 0.0, 9.81)});
  }
  EXPECT_EQ(moving.try_start(Time::from_s(0.7), findings), Start::kInMotion);
  EXPECT_EQ(moving.bias().gyro_radps, Vec3::Zero());
}

TEST(InertialGuess, accepts_accelerations_in_units_of_g_and_reports_it) {
  InertialGuess guess = fresh();
  FindingList findings;
  feed(guess, 0.0, 1.0, Vec3(0.0, 0.0, 1.0));
  EXPECT_EQ(guess.try_start(Time::from_s(1.0), findings), Start::kAtRest);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "odometry.accel_in_g");
  feed(guess, 1.005, 2.0, Vec3(0.0, 0.0, 1.0));
  std::vector<TimedPose> path;
  guess.predict(Time::from_s(2.0), path);
  EXPECT_LT(guess.T_odom_body().p.norm(), 1e-6);
}

TEST(InertialGuess, reports_a_wrong_norm_of_gravity) {
  InertialGuess guess = fresh();
  FindingList findings;
  feed(guess, 0.0, 1.0, Vec3(0.0, 0.0, 5.0));
  static_cast<void>(guess.try_start(Time::from_s(1.0), findings));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "odometry.accel_norm");
}

TEST(InertialGuess, predicts_the_body_pose_from_an_imu_with_lever_arm) {
  testing::Drive drive;
  testing::Imu imu;
  imu.T_body_imu = {geometry::rotation_from_rpy(0.2, -0.1, 1.0), Vec3(-0.2, 0.1, -0.1)};
  imu.gyro_noise_radps = 0.0;
  imu.accel_noise_mps2 = 0.0;
  Rng rng(1);
  InertialGuess guess = fresh(imu.T_body_imu);
  for (int k = 0; k <= 400; ++k) guess.add(imu.sample(drive, 0.005 * k, rng));
  FindingList findings;
  ASSERT_EQ(guess.try_start(Time::from_s(1.0), findings), Start::kAtRest);
  std::vector<TimedPose> path;
  guess.predict(Time::from_s(2.0), path);
  const SE3 truth = drive.pose(2.0);
  EXPECT_LT((guess.T_odom_body().p - truth.p).norm(), 2e-3);
  EXPECT_LT(geometry::so3_log(truth.R.transpose() * guess.T_odom_body().R).norm(), 2e-3);
  const Vec3 v = (drive.pose(2.0001).p - drive.pose(1.9999).p) / 2e-4;
  EXPECT_LT((guess.v_odom_body_mps() - v).norm(), 1e-2);
  EXPECT_EQ(path.front().t, Time::from_s(1.0));
  EXPECT_EQ(path.back().t, Time::from_s(2.0));
}

TEST(InertialGuess, coasts_through_a_gap_at_constant_velocity) {
  InertialGuess guess = fresh();
  guess.reset(Time::from_s(0.0), {});
  std::vector<TimedPose> path;
  const SE3 step{geometry::so3_exp(Vec3(0, 0, 0.02)), Vec3(0.1, 0.0, 0.0)};
  guess.predict(Time::from_s(0.1), path);
  guess.correct(step);
  guess.predict(Time::from_s(0.2), path);
  EXPECT_FALSE(guess.inertial());
  EXPECT_LT((guess.T_odom_body().p - Vec3(0.2, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_NEAR(geometry::so3_log(guess.T_odom_body().R).z(), 0.04, 1e-9);
}

TEST(InertialGuess, keeps_its_velocity_when_the_pose_is_moved) {
  InertialGuess guess = fresh();
  guess.reset(Time::from_s(0.0), {});
  std::vector<TimedPose> path;
  guess.predict(Time::from_s(0.1), path);
  guess.correct({geometry::Mat3::Identity(), Vec3(0.1, 0.0, 0.0)});  // 1 m/s
  guess.move({geometry::Mat3::Identity(), Vec3(5.0, 0.0, 0.0)});
  EXPECT_LT((guess.T_odom_body().p - Vec3(5.1, 0.0, 0.0)).norm(), 1e-9);
  guess.predict(Time::from_s(0.2), path);
  guess.correct({geometry::Mat3::Identity(), Vec3(5.2, 0.0, 0.0)});
  EXPECT_LT((guess.v_odom_body_mps() - Vec3(1.0, 0.0, 0.0)).norm(), 1e-9);
}

TEST(InertialGuess, estimates_biases_that_appear_after_the_start) {
  InertialGuess guess(ImuNoiseSettings{}, {}, 0.5, 0.05);
  FindingList findings;
  feed(guess, 0.0, 1.0, Vec3(0.0, 0.0, 9.81));
  ASSERT_EQ(guess.try_start(Time::from_s(1.0), findings), Start::kAtRest);
  const Vec3 accel_bias(0.1, -0.05, 0.08);
  const Vec3 gyro_bias(0.0, 0.002, 0.003);
  feed(guess, 1.005, 31.0, Vec3(0.0, 0.0, 9.81) + accel_bias, gyro_bias);
  std::vector<TimedPose> path;
  for (int k = 11; k <= 310; ++k) {
    guess.predict(Time::from_s(0.1 * k), path);
    guess.correct({geometry::Mat3::Identity(), Vec3(0.01 * (k - 10), 0.0, 0.0)});  // 0.1 m/s
  }
  EXPECT_LT((guess.bias().accel_mps2 - accel_bias).norm(), 5e-3);
  EXPECT_LT((guess.bias().gyro_radps - gyro_bias).norm(), 2e-4);
  EXPECT_LT((guess.v_odom_body_mps() - Vec3(0.1, 0.0, 0.0)).norm(), 2e-3);
}

// At standstill the gyro's mean is its bias; if the LiDAR shows turning it is not, however even.
TEST(InertialGuess, estimates_gyro_bias_only_while_the_lidar_measures_no_rotation) {
  for (const bool turning : {false, true}) {
    InertialGuess guess = fresh();
    FindingList findings;
    feed(guess, 0.0, 1.0, Vec3(0.0, 0.0, 9.81));
    ASSERT_EQ(guess.try_start(Time::from_s(1.0), findings), Start::kAtRest);
    feed(guess, 1.005, 4.0, Vec3(0.0, 0.0, 9.81), Vec3(0.0, 0.0, 0.03));
    std::vector<TimedPose> path;
    for (int k = 11; k <= 30; ++k) {
      guess.predict(Time::from_s(0.1 * k), path);
      const double yaw = turning ? 0.03 * (0.1 * k - 1.0) : 0.0;
      guess.correct({geometry::so3_exp(Vec3(0, 0, yaw)), Vec3::Zero()});
    }
    EXPECT_NEAR(guess.bias().gyro_radps.z(), turning ? 0.0 : 0.03, 1e-9);
  }
}

}  // namespace
}  // namespace rali::odometry::paper
