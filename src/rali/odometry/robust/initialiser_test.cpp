#include "rali/odometry/robust/initialiser.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;

const Vec3 kTrueBias(0.01, -0.02, 0.005);
const Vec3 kGravity(0.3, -0.4, -9.797);  // odom is tilted by 3 degrees

/// A hand-held motion, or standstill.
struct Motion {
  double size_m = 0.5;
  double lidar_noise_m = 0.002;
  double accel_noise_mps2 = 0.05;
  Vec3 accel_bias_mps2 = Vec3::Zero();
  Rng rng{1, "motion"};

  [[nodiscard]] SE3 pose(double t) const {
    return {so3_exp(size_m * Vec3(0.2 * std::sin(1.3 * t), 0.3 * std::sin(1.9 * t),
                                  0.8 * std::sin(0.9 * t))),
            size_m * Vec3(std::sin(1.7 * t), 1.0 - std::cos(1.1 * t), 0.4 * std::sin(2.3 * t))};
  }

  [[nodiscard]] Vec3 velocity(double t) const {
    return (pose(t + 1e-4).p - pose(t - 1e-4).p) / 2e-4;
  }

  Vec3 noise() { return {rng.normal(), rng.normal(), rng.normal()}; }

  void record(double duration_s, InertialBuffer& imu, std::vector<TrackedPose>& track) {
    const Vec3 g = 9.81 * kGravity.normalized();
    for (int k = 0; 0.005 * k <= duration_s + 1e-9; ++k) {
      const double t = 0.005 * k;
      const SE3 before = pose(t - 1e-3);
      const SE3 after = pose(t + 1e-3);
      const SE3 now = pose(t);
      const Vec3 a = (after.p - 2.0 * now.p + before.p) / 1e-6;
      imu.add(
          {Time::from_s(t),
           geometry::so3_log(before.R.transpose() * after.R) / 2e-3 + kTrueBias + 0.003 * noise(),
           now.R.transpose() * (a - g) + accel_bias_mps2 + accel_noise_mps2 * noise()});
      if (k % 20 == 0) {
        SE3 seen = now;
        seen.p += lidar_noise_m * noise();
        seen.R = seen.R * so3_exp(3e-4 * noise());
        track.push_back(
            {Time::from_s(t), seen, lidar_noise_m * lidar_noise_m * geometry::Mat3::Identity()});
      }
    }
  }
};

double speed_sigma_mps(const InitialGuess& guess) {
  return std::sqrt(guess.velocity_covariance.diagonal().maxCoeff());
}

double tilt_sigma_rad(const InitialGuess& guess) {
  return std::sqrt(guess.bias_gravity_covariance.diagonal().tail<2>().maxCoeff());
}

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

TEST(Initialiser, estimates_gravity_and_gyro_bias_at_standstill) {
  Motion still;
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  const auto guess = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(guess.has_value());
  EXPECT_TRUE(guess->at_rest);
  EXPECT_LT(angle(guess->g_odom_mps2, kGravity), 1e-3);
  EXPECT_NEAR(guess->g_odom_mps2.norm(), 9.81, 1e-9);
  EXPECT_LT((guess->gyro_bias_radps - kTrueBias).norm(), 3.0 * guess->gyro_bias_sigma_radps);
  EXPECT_LT((guess->gyro_bias_radps - kTrueBias).norm(), 1e-3);
  EXPECT_EQ(guess->v_odom_mps, Vec3(Vec3::Zero()));
  EXPECT_LT(speed_sigma_mps(*guess), 0.05);
}

TEST(Initialiser, gravity_error_at_standstill_is_that_of_averaging_all_samples) {
  // From the last 0.7 s alone the sigma of the direction would be 1.3 times as large; that error
  // drives the pose off along a tunnel.
  constexpr int kRuns = 200;
  double sum2_rad2 = 0.0;
  for (int k = 0; k < kRuns; ++k) {
    Motion still;
    still.size_m = 0.0;
    still.rng = Rng(static_cast<std::uint64_t>(k), "gravity");
    InertialBuffer imu;
    std::vector<TrackedPose> track;
    still.record(1.2, imu, track);
    track.back().T_odom_body = track.front().T_odom_body;  // excludes the LiDAR's noise
    track.back().T_odom_body.R.setIdentity();
    const auto guess = solve_initial(track, imu, {}, {});
    ASSERT_TRUE(guess && guess->at_rest);
    sum2_rad2 += std::pow(angle(guess->g_odom_mps2, kGravity), 2);
  }
  const double expected_rad = std::sqrt(2.0 / 240.0) * 0.05 / 9.81;
  EXPECT_NEAR(std::sqrt(sum2_rad2 / kRuns), expected_rad, 0.15 * expected_rad);
}

TEST(Initialiser, estimates_accelerometer_bias_along_gravity_at_standstill) {
  Motion still;
  still.size_m = 0.0;
  still.accel_bias_mps2 = 0.2 * (-kGravity.normalized());
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  const auto guess = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(guess.has_value());
  EXPECT_LT((guess->accel_bias_mps2 - still.accel_bias_mps2).norm(), 0.02);
}

TEST(Initialiser, correlates_bias_and_gravity_so_their_sum_is_well_determined) {
  // Otherwise a vehicle at standstill would appear to accelerate by 0.1 m/s2.
  Motion still;
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  const auto guess = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(guess.has_value());
  // Acceleration in odom: R (a - b) + g, so its error is -R db - [g]x B dg.
  Eigen::Matrix<double, 3, 5> J;
  J << -track.back().T_odom_body.R,
      -geometry::skew(guess->g_odom_mps2) * gravity_basis(guess->g_odom_mps2);
  const geometry::Mat3 P = J * guess->bias_gravity_covariance * J.transpose();
  EXPECT_LT(std::sqrt(P(0, 0)), 0.03);
  EXPECT_LT(std::sqrt(P(1, 1)), 0.03);
  EXPECT_GT(std::sqrt(guess->bias_gravity_covariance(0, 0)), 0.05);
}

TEST(Initialiser, does_not_assume_standstill_with_vibration_and_a_degenerate_lidar) {
  Motion still;
  still.accel_noise_mps2 = 0.5;  // an engine, or wheels on a smooth floor
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  for (TrackedPose& p : track) p.covariance_m2(0, 0) = 1.0;
  const auto guess = solve_initial(track, imu, {}, {});
  EXPECT_TRUE(!guess || (!guess->at_rest && speed_sigma_mps(*guess) > 0.5));
}

TEST(Initialiser, recognises_an_idling_engine_after_2_s_with_a_degenerate_lidar) {
  Motion still;
  still.accel_noise_mps2 = 0.5;
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(2.2, imu, track);
  for (TrackedPose& p : track) p.covariance_m2(0, 0) = 1e4;
  const auto guess = solve_initial(track, imu, {}, {}, true);
  ASSERT_TRUE(guess.has_value());
  EXPECT_TRUE(guess->at_rest);
  EXPECT_LT(speed_sigma_mps(*guess), 0.05);
  const auto other_view = solve_initial(track, imu, {}, {}, false);
  EXPECT_TRUE(!other_view || !other_view->at_rest);
}

TEST(Initialiser, initial_speed_sigma_scales_with_usual_vehicle_speed_when_degenerate) {
  Motion shaken;
  shaken.accel_noise_mps2 = 0.5;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  shaken.record(1.2, imu, track);
  for (TrackedPose& p : track) p.covariance_m2(0, 0) = 1e4;
  InitialisationSettings hasty;
  hasty.give_up_s = 1.0;
  const auto cart = solve_initial(track, imu, hasty, {}, false, 2.0);
  const auto drone = solve_initial(track, imu, hasty, {}, false, 8.0);
  ASSERT_TRUE(cart && drone);
  EXPECT_NEAR(drone->v_first_sigma_mps / cart->v_first_sigma_mps, 4.0, 0.5);
}

TEST(Initialiser, assumes_standstill_without_vibration_when_the_lidar_is_degenerate) {
  Motion still;
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  for (TrackedPose& p : track) p.covariance_m2(0, 0) = 1.0;
  const auto guess = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(guess.has_value());
  EXPECT_LT(speed_sigma_mps(*guess), 0.05);
}

TEST(Initialiser, detects_standstill_despite_lidar_drift_along_a_degenerate_direction) {
  // A corridor with sparse rings and a map one scan old: poses drift along it.
  Motion still;
  still.size_m = 0.0;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  still.record(1.2, imu, track);
  for (TrackedPose& p : track) {
    p.T_odom_body.p.x() -= 2.0 * p.t.s();
    p.covariance_m2(0, 0) = 0.8;
  }
  const auto guess = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(guess.has_value());
  EXPECT_TRUE(guess->at_rest);
  EXPECT_LT(angle(guess->g_odom_mps2, kGravity), 1e-3);
}

TEST(Initialiser, finds_gravity_with_a_degenerate_lidar_given_a_longer_time_limit) {
  Motion moving;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  moving.record(3.0, imu, track);
  for (TrackedPose& p : track) {
    const double t = p.t.s();
    p.T_odom_body.p.x() += 0.5 * t * t;  // 1 m/s2 along the degenerate direction
    p.covariance_m2(0, 0) = 1.0 + t * t;
  }
  const auto early = solve_initial(track, imu, {}, {});
  ASSERT_TRUE(early.has_value());
  EXPECT_FALSE(early->gravity_known);
  InitialisationSettings patient;
  patient.give_up_s = 2.0;
  const auto guess = solve_initial(track, imu, patient, {});
  ASSERT_TRUE(guess.has_value());
  EXPECT_TRUE(guess->gravity_known);
  EXPECT_LT(angle(guess->g_odom_mps2, kGravity), 3.0 * tilt_sigma_rad(*guess));
}

TEST(Initialiser, estimates_gravity_and_velocity_in_motion_within_3_sigma) {
  for (const double bias : {0.0, 0.1}) {
    Motion moving;
    moving.accel_bias_mps2 = Vec3(bias, -bias, 0.0);
    InertialBuffer imu;
    std::vector<TrackedPose> track;
    moving.record(3.0, imu, track);
    const auto guess = solve_initial(track, imu, {}, {});
    ASSERT_TRUE(guess.has_value()) << bias;
    EXPECT_TRUE(guess->gravity_known) << bias;
    EXPECT_FALSE(guess->at_rest);
    EXPECT_LT(angle(guess->g_odom_mps2, kGravity), 3.0 * tilt_sigma_rad(*guess)) << bias;
    EXPECT_LT(tilt_sigma_rad(*guess), 0.1);
    EXPECT_LT((guess->v_odom_mps - moving.velocity(3.0)).norm(), 3.0 * speed_sigma_mps(*guess));
    EXPECT_LT((guess->gyro_bias_radps - kTrueBias).norm(), 3.0 * guess->gyro_bias_sigma_radps);
  }
}

TEST(Initialiser, sigma_of_mean_force_as_gravity_decreases_with_duration) {
  // A change of 1 m/s in 4 s is an acceleration of 0.25 m/s2; in 1 s it is at most 0.7.
  EXPECT_DOUBLE_EQ(mean_force_sigma_mps2(4.0), 0.25);
  EXPECT_DOUBLE_EQ(mean_force_sigma_mps2(1.0), 0.7);
  EXPECT_DOUBLE_EQ(mean_force_sigma_mps2(0.0), 0.7);
}

TEST(Initialiser, waits_without_enough_poses_or_imu_samples) {
  Motion moving;
  InertialBuffer imu;
  std::vector<TrackedPose> track;
  EXPECT_FALSE(solve_initial(track, imu, {}, {}).has_value());
  moving.record(0.8, imu, track);
  EXPECT_FALSE(solve_initial(track, imu, {}, {}).has_value());
  EXPECT_FALSE(solve_initial(track, InertialBuffer{}, {}, {}).has_value());
}

TEST(Initialiser, refuses_accelerations_in_units_of_g) {
  Motion moving;
  InertialBuffer imu;
  InertialBuffer in_g;
  std::vector<TrackedPose> track;
  moving.record(3.0, imu, track);
  for (sensor::ImuSample s : imu.between(Time{}, Time::from_s(3.0))) {
    s.accel_mps2 /= 9.81;
    in_g.add(s);
  }
  EXPECT_FALSE(solve_initial(track, in_g, {}, {}).has_value());
}

TEST(InertialBuffer, interpolates_between_samples_and_clamps_beyond_them) {
  InertialBuffer b;
  EXPECT_TRUE(b.empty());
  b.add({Time::from_s(1.0), Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)});
  b.add({Time::from_s(2.0), Vec3(4.0, 0.0, 0.0), Vec3(3.0, 0.0, 0.0)});
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(1.25)).gyro_radps.x(), 1.0);
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(1.25)).accel_mps2.x(), 1.5);
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(0.0)).accel_mps2.x(), 1.0);
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(9.0)).accel_mps2.x(), 3.0);
  EXPECT_EQ(b.between(Time::from_s(1.0), Time::from_s(2.0)).size(), 2U);
  EXPECT_EQ(b.between(Time::from_s(1.1), Time::from_s(1.9)).size(), 0U);
  EXPECT_DOUBLE_EQ(b.longest_gap_s(Time::from_s(0.5), Time::from_s(2.2)), 1.0);
  EXPECT_DOUBLE_EQ(b.longest_gap_s(Time::from_s(1.5), Time::from_s(5.0)), 3.0);
}

TEST(InertialBuffer, dropping_old_samples_keeps_those_needed_for_interpolation) {
  InertialBuffer b;
  for (int k = 0; k < 10; ++k) b.add({Time::from_s(k), Vec3(k, 0.0, 0.0), Vec3::Zero()});
  b.drop_before(Time::from_s(4.5));
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(4.5)).gyro_radps.x(), 4.5);
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(1.0)).gyro_radps.x(), 4.0);  // older ones are gone
  b.drop_before(Time::from_s(100.0));
  EXPECT_FALSE(b.empty());
  EXPECT_DOUBLE_EQ(b.at(Time::from_s(100.0)).gyro_radps.x(), 9.0);
}

TEST(PropagateOver, ends_at_the_requested_time_and_records_each_step_pose) {
  InertialBuffer b;
  for (int k = 0; k <= 10; ++k) {
    b.add({Time::from_s(0.01 * k), Vec3(0.0, 0.0, 1.0), Vec3(0.0, 0.0, 9.81)});
  }
  FilterState s;
  s.v = Vec3(1.0, 0.0, 0.0);
  std::vector<TimedPose> poses;
  constexpr ProcessNoise kNoise{3e-3, 0.03, 1e-5, 1e-4};
  propagate_over(s, b, Time::from_s(0.055), kNoise, poses);
  EXPECT_EQ(s.t, Time::from_s(0.055));
  ASSERT_EQ(poses.size(), 6U);
  EXPECT_EQ(poses.back().t, s.t);
  EXPECT_NEAR(s.T_odom_body.p.x(), 0.055, 1e-9);
  EXPECT_NEAR(geometry::so3_log(s.T_odom_body.R).z(), 0.055, 1e-9);
  // A gap is bridged with the last sample and a much larger covariance than without a gap.
  FilterState gap = s;
  propagate_over(gap, b, Time::from_s(1.0), kNoise, poses);
  EXPECT_NEAR(gap.T_odom_body.p.x(), 1.0, 1e-6);
  EXPECT_GT(gap.P(kVel, kVel), 100.0 * s.P(kVel, kVel));
}

}  // namespace
}  // namespace rali::odometry
