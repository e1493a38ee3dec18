#include "rali/imu/motion_noise.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::imu {
namespace {

using geometry::Mat3;
using geometry::Vec3;

Vec3 normal3(Rng& rng) {
  const double x = rng.normal();
  const double y = rng.normal();
  const double z = rng.normal();
  return {x, y, z};
}

/// A vehicle with the given errors of the inertial sensor and the given LiDAR noise.
struct Drive {
  double accel_mps2_rthz = 0.03, gyro_radps_rthz = 3e-3;
  double lidar_m = 0.002, lidar_rad = 3e-4;
  Vec3 bias_mps2 = Vec3::Zero();
  double period_s = 0.1;
  Mat3 known = Mat3::Identity();
  Mat3 rotation_known = Mat3::Identity();
  double roll_rad = 0.0;  ///< noise of the LiDAR's roll

  MotionNoise run(const NoiseDensity& claimed, double span_s) const {
    MotionNoise meter(claimed, {});
    Rng rng(5, "drive");
    constexpr double kSample_s = 0.005;
    Vec3 p = Vec3::Zero();
    Vec3 v(1.0, 0.0, 0.0);
    for (double t = 0.0; t < span_s; t += period_s) {
      MotionStep step;
      step.t = Time::from_ns(static_cast<std::int64_t>(t * 1e9) + 1);
      Vec3 turn = Vec3::Zero();
      for (double s = 0.0; s < period_s - 1e-9; s += kSample_s) {
        const Vec3 truth(0.3 * std::sin(t + s), 0.2 * std::cos(2.0 * (t + s)), 0.0);
        const Vec3 inertial =
            truth + bias_mps2 + accel_mps2_rthz / std::sqrt(kSample_s) * normal3(rng);
        step.dp_m += step.dv_mps * kSample_s + 0.5 * kSample_s * kSample_s * inertial;
        step.dv_mps += kSample_s * inertial;
        p += v * kSample_s + 0.5 * kSample_s * kSample_s * truth;
        v += kSample_s * truth;
        turn += kSample_s * gyro_radps_rthz / std::sqrt(kSample_s) * normal3(rng);
      }
      step.dR = geometry::so3_exp(turn);
      Vec3 noise_rad = lidar_rad * normal3(rng);
      if (roll_rad > 0.0) noise_rad.x() += roll_rad * rng.normal();
      step.R_odom_body = geometry::so3_exp(noise_rad);
      step.p_odom_m = p + lidar_m * normal3(rng);
      step.known = known;
      step.rotation_known = rotation_known;
      meter.add(step);
    }
    return meter;
  }
};

TEST(PriorNoise, weights_typical_vehicle_noise_above_the_data_sheet) {
  const NoiseDensity low = prior_noise({1e-5, 1e-4}, {});
  const NoiseDensity high = prior_noise({1e-2, 0.1}, {});
  EXPECT_GT(low.accel_mps2_rthz, 0.01);
  EXPECT_LT(high.accel_mps2_rthz, 0.05);
  EXPECT_GT(low.gyro_radps_rthz, 1e-3);
  EXPECT_LT(high.gyro_radps_rthz, 1e-2);
  const NoiseDensity same = prior_noise({3e-3, 0.03}, {});
  EXPECT_NEAR(same.accel_mps2_rthz, 0.03, 1e-12);
  EXPECT_NEAR(same.gyro_radps_rthz, 3e-3, 1e-12);
}

TEST(MotionNoise, estimates_the_true_noise_regardless_of_the_claimed_density) {
  for (const double truth : {0.02, 0.06, 0.2}) {
    for (const double claimed : {1e-4, 0.03, 1.0}) {
      Drive drive;
      drive.accel_mps2_rthz = truth;
      drive.gyro_radps_rthz = 0.1 * truth;
      const NoiseDensity used = drive.run({0.1 * claimed, claimed}, 30.0).density();
      EXPECT_NEAR(std::log(used.accel_mps2_rthz / truth), 0.0, 0.35) << truth << ' ' << claimed;
      EXPECT_NEAR(std::log(used.gyro_radps_rthz / (0.1 * truth)), 0.0, 0.35);
    }
  }
}

TEST(MotionNoise, density_is_at_least_the_measured_one_given_enough_values) {
  // In a corridor one direction is well observable, and the figure is based on few values.
  Drive drive;
  drive.accel_mps2_rthz = 0.3;
  drive.known = Vec3(0.0, 1.0, 0.0).asDiagonal();
  for (const double span_s : {2.5, 8.0, 15.0, 30.0}) {
    const MotionNoise meter = drive.run({1e-6, 1e-4}, span_s);
    const double used = meter.density().accel_mps2_rthz;
    if (meter.measured().accel_mps2_rthz) {
      EXPECT_GE(used, meter.accel().value) << span_s;
      EXPECT_EQ(used, *meter.measured().accel_mps2_rthz);
    } else {
      EXPECT_LT(used, meter.accel().value) << "a few values may be far off: the prior counts";
    }
  }
  EXPECT_FALSE(drive.run({1e-6, 1e-4}, 2.5).measured().accel_mps2_rthz);
  EXPECT_TRUE(drive.run({1e-6, 1e-4}, 30.0).measured().accel_mps2_rthz);
}

TEST(MotionNoise, is_not_inflated_by_biases_or_lidar_noise) {
  Drive drive;
  drive.accel_mps2_rthz = 0.01;
  drive.bias_mps2 = {0.2, -0.1, 0.05};
  EXPECT_LT(drive.run({3e-3, 0.03}, 60.0).density().accel_mps2_rthz, 0.02);
  drive.bias_mps2.setZero();
  drive.lidar_m = 0.006;
  EXPECT_LT(drive.run({3e-3, 0.03}, 60.0).density().accel_mps2_rthz, 0.03);
}

TEST(MotionNoise, works_at_a_scan_rate_of_2_hz) {
  Drive drive;
  drive.period_s = 0.5;
  drive.accel_mps2_rthz = 0.1;
  const NoiseDensity used = drive.run({1e-5, 1e-4}, 60.0).density();
  EXPECT_NEAR(std::log(used.accel_mps2_rthz / 0.1), 0.0, 0.5);
}

TEST(MotionNoise, keeps_the_prior_where_the_lidar_is_degenerate) {
  Drive drive;
  drive.accel_mps2_rthz = 0.5;
  drive.known.setZero();
  const MotionNoise meter = drive.run({3e-3, 0.03}, 30.0);
  EXPECT_NEAR(meter.density().accel_mps2_rthz, 0.03, 1e-12);
  EXPECT_EQ(meter.accel().count, 0.0);
}

TEST(MotionNoise, measures_the_gyro_by_pitch_and_yaw_in_a_round_pipe) {
  Drive drive;
  drive.gyro_radps_rthz = 3e-4;
  drive.roll_rad = 0.1;  // a round section does not observe roll
  drive.rotation_known = Vec3(0.0, 1.0, 1.0).asDiagonal();
  const MotionNoise meter = drive.run({3e-3, 0.03}, 30.0);
  ASSERT_TRUE(meter.measured().gyro_radps_rthz);
  EXPECT_NEAR(std::log(meter.density().gyro_radps_rthz / 3e-4), 0.0, 0.35);
}

TEST(MotionNoise, a_single_jolt_raises_the_estimate_less_than_twofold) {
  const Drive drive;
  const double calm = drive.run({3e-3, 0.03}, 20.0).density().accel_mps2_rthz;
  MotionNoise meter = drive.run({3e-3, 0.03}, 20.0);
  MotionStep jolt;
  jolt.t = Time::from_ns(20'000'000'001);
  jolt.known = Mat3::Identity();
  jolt.rotation_known = Mat3::Identity();
  jolt.p_odom_m = {100.0, 0.0, 0.0};
  meter.add(jolt);
  EXPECT_LT(meter.density().accel_mps2_rthz, 2.0 * calm);
}

}  // namespace
}  // namespace rali::imu
