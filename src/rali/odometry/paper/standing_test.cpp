#include "rali/odometry/paper/standing.hpp"

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/imu/rest.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kGyroNoise = 5e-4;  // [rad/s/rtHz], 200 samples a second
constexpr double kAccelNoise = 2e-3;

/// A vehicle at standstill; its IMU has white noise, its LiDAR reports the position `seen_m`.
struct Stand {
  explicit Stand(std::uint64_t seed, const SE3& T_body_imu = {})
      : rng(seed),
        guess(ImuNoiseSettings{}, T_body_imu, 0.5, 0.0),
        R_imu_body(T_body_imu.R.transpose()) {
    FindingList findings;
    sample_until(1.0);
    EXPECT_EQ(guess.try_start(Time::from_s(1.0), findings), InertialGuess::Start::kAtRest);
    standing.learn(Time::from_s(0.0), Time::from_s(1.0));
    t_s = 1.0;
  }

  void sample_until(double end_s) {
    const auto white = [this](double sigma) -> Vec3 {
      return sigma * Vec3(rng.normal(), rng.normal(), rng.normal());
    };
    for (; sampled_s <= end_s + 1e-9; sampled_s += 0.005) {
      const double rate = std::sqrt(200.0);
      const sensor::ImuSample sample{
          Time::from_s(sampled_s), white(shakes * kGyroNoise * rate),
          R_imu_body * Vec3(0.0, 0.0, 9.81) + white(shakes * kAccelNoise * rate)};
      guess.add(sample);
      standing.add(sample);
    }
  }

  bool step(const Vec3& seen_m) {
    t_s += 0.1;
    sample_until(t_s);
    std::vector<TimedPose> path;
    guess.predict(Time::from_s(t_s), path);
    const SE3 seen{geometry::Mat3::Identity(), seen_m};
    const geometry::Mat6 information = 1e6 * geometry::Mat6::Identity();
    guess.fuse(information, information * geometry::boxminus(seen, guess.T_odom_body()));
    const bool stands = standing.update(Time::from_s(t_s), guess, degenerate_odom, held);
    if (stands) {
      if (!held) {
        held = guess.T_odom_body();
        guess.start_standstill();
      }
      guess.stay(*held);
    } else {
      held.reset();
    }
    return stands;
  }

  Rng rng;
  InertialGuess guess;
  Standing standing{RobustSettings{}, kGyroNoise};
  geometry::Mat3 R_imu_body;
  std::optional<SE3> held;
  std::optional<Vec3> degenerate_odom;
  double shakes = 1.0;
  double t_s = 0.0, sampled_s = 0.0;
};

TEST(Standing, lasts_200_s_although_single_noise_windows_fail_by_chance) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Stand vehicle(seed);
    for (int k = 0; k < 20; ++k) vehicle.step(Vec3::Zero());
    ASSERT_TRUE(vehicle.held);
    for (int k = 0; k < 2000; ++k) {
      ASSERT_TRUE(vehicle.step(Vec3::Zero())) << vehicle.t_s << " s, seed " << seed;
    }
  }
}

TEST(Standing, starts_with_an_imu_rotated_against_the_body) {
  Stand vehicle(4, {geometry::rotation_from_rpy(0.0, 1.2, 0.4), Vec3::Zero()});
  for (int k = 0; k < 20; ++k) vehicle.step(Vec3::Zero());
  EXPECT_TRUE(vehicle.held);
}

TEST(Standing, ends_when_the_imu_measures_driving) {
  Stand vehicle(5);
  for (int k = 0; k < 100; ++k) vehicle.step(Vec3::Zero());
  ASSERT_TRUE(vehicle.held);
  vehicle.shakes = 4.0;
  bool stands = true;
  for (int k = 1; k <= 4; ++k) stands = vehicle.step(Vec3(0.02 * k, 0.0, 0.0));
  EXPECT_FALSE(stands) << "0.08 m alone would not end it";
}

TEST(Standing, ends_when_the_lidar_measures_a_shift_of_15_cm) {
  Stand vehicle(6);
  for (int k = 0; k < 100; ++k) vehicle.step(Vec3::Zero());
  ASSERT_TRUE(vehicle.held);
  EXPECT_FALSE(vehicle.step(Vec3(0.15, 0.0, 0.0)));
}

TEST(Standing, lasts_when_the_measured_shift_is_only_along_a_degenerate_direction) {
  Stand vehicle(8);
  for (int k = 0; k < 100; ++k) vehicle.step(Vec3::Zero());
  ASSERT_TRUE(vehicle.held);
  vehicle.degenerate_odom = Vec3::UnitX();
  EXPECT_TRUE(vehicle.step(Vec3(0.11, 0.0, 0.0)));
  EXPECT_FALSE(vehicle.step(Vec3(0.0, 0.11, 0.0)));
}

}  // namespace
}  // namespace rali::odometry::paper
