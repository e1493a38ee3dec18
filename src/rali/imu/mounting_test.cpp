#include "rali/imu/mounting.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "rali/imu/turning_for_test.hpp"

namespace rali::imu {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kDeg = std::numbers::pi / 180.0;

MountingByTurning judged(const test::TurningPair& pair, const Mat3& assumed) {
  const auto lidar = pair.lidar();
  const auto samples = pair.imu();
  return judge_mounting(assumed, lidar, samples, study_rotations(lidar, samples));
}

double angle_deg(const Mat3& a, const Mat3& b) {
  return geometry::so3_log(a.transpose() * b).norm() / kDeg;
}

TEST(Mounting, is_confirmed_if_both_sensors_turn_alike) {
  EXPECT_EQ(judged({}, Mat3::Identity()).verdict, MountingVerdict::kAgrees);
}

TEST(Mounting, is_found_from_turning_about_all_axes) {
  test::TurningPair pair;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.1, 25.0 * kDeg, 0.5);
  const MountingByTurning found = judged(pair, Mat3::Identity());
  EXPECT_EQ(found.verdict, MountingVerdict::kContradicts);
  EXPECT_LT(angle_deg(found.R_imu_lidar, pair.R_imu_lidar), 1.0);
  EXPECT_EQ(judged(pair, pair.R_imu_lidar).verdict, MountingVerdict::kAgrees);
}

TEST(Mounting, keeps_what_was_assumed_about_the_only_axis_of_turning) {
  test::TurningPair pair;
  pair.tilt_radps = 0.0;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.0, 25.0 * kDeg, 0.0);
  const MountingByTurning found = judged(pair, Mat3::Identity());
  EXPECT_EQ(found.verdict, MountingVerdict::kContradicts);
  EXPECT_LT(angle_deg(found.R_imu_lidar, pair.R_imu_lidar), 1.0);
  // A rotation about the axis itself leaves no trace.
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.0, 0.0, 0.5);
  const MountingByTurning turned = judged(pair, Mat3::Identity());
  EXPECT_EQ(turned.verdict, MountingVerdict::kAgrees);
}

/// The LiDAR's turns with noise, in rad per turn of 0.06.
MountingByTurning judged_with_noise(test::TurningPair pair, double noise_rad) {
  pair.tilt_radps = 0.0;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.1, 18.0 * kDeg, 0.0);
  auto lidar = pair.lidar();
  Rng rng(11, "rough walls");
  for (LidarTurn& turn : lidar) {
    turn.turn_lidar_rad += noise_rad * Vec3(rng.normal(), rng.normal(), rng.normal());
  }
  const auto samples = pair.imu();
  return judge_mounting(Mat3::Identity(), lidar, samples, study_rotations(lidar, samples));
}

TEST(Mounting, is_found_through_the_noise_of_rough_walls) {
  const MountingByTurning found = judged_with_noise({}, 0.008);
  EXPECT_GT(found.misfit_rad, 0.2) << "more noise than a clean study would pass";
  EXPECT_EQ(found.verdict, MountingVerdict::kContradicts);
  EXPECT_LT(angle_deg(found.R_imu_lidar, geometry::rotation_from_rpy(0.1, 18.0 * kDeg, 0.0)), 4.0);
}

TEST(Mounting, is_undecided_if_the_lidar_saw_only_noise) {
  EXPECT_EQ(judged_with_noise({}, 0.1).verdict, MountingVerdict::kUndecided);
}

TEST(Mounting, is_undecided_if_nothing_turned) {
  test::TurningPair pair;
  pair.rate_radps = 0.0;
  pair.R_imu_lidar = geometry::rotation_from_rpy(0.0, 1.0, 0.0);
  EXPECT_EQ(judged(pair, Mat3::Identity()).verdict, MountingVerdict::kUndecided);
}

}  // namespace
}  // namespace rali::imu
