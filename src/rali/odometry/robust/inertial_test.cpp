#include "rali/odometry/robust/inertial.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry {
namespace {

/// A second at 400 Hz of a level person who turns ever faster, up to 1.2 rad/s, with a gyro and an
/// accelerometer of the given ranges.
InertialBuffer turning(double gyro_max_radps, double accel_max_mps2) {
  InertialBuffer buffer;
  Rng rng(1, "turning");
  for (int k = 0; k <= 400; ++k) {
    sensor::ImuSample s;
    s.t = Time::from_s(k / 400.0);
    s.gyro_radps = {0.01 * rng.normal(), 0.01 * rng.normal(), 0.003 * k + 0.01 * rng.normal()};
    s.accel_mps2 = {0.1 * rng.normal(), 0.1 * rng.normal(), 9.81 + 4.0 * (k > 300) + rng.normal()};
    s.gyro_radps.z() = std::min(s.gyro_radps.z(), gyro_max_radps);
    s.accel_mps2.z() = std::min(s.accel_mps2.z(), accel_max_mps2);
    buffer.add(s);
  }
  return buffer;
}

/// Covariance after the last tenth of that second, from a state without uncertainty.
StateCov grown(const InertialBuffer& buffer) {
  FilterState state;
  state.t = Time::from_s(0.9);
  state.g_odom_mps2 = {0.0, 0.0, -9.81};
  state.P.setZero();
  ProcessNoise noise;
  noise.gyro_radps_rthz = 1e-3;
  noise.accel_mps2_rthz = 1e-2;
  std::vector<TimedPose> poses;
  propagate_over(state, buffer, Time::from_s(1.0), noise, poses);
  return state.P;
}

TEST(Inertial, a_saturated_gyro_increases_only_the_rotation_variance_about_its_axis) {
  const InertialBuffer buffer = turning(0.75, 100.0);
  const ClippedAxes clipped = buffer.clipped(Time::from_s(0.9), Time::from_s(1.0));
  EXPECT_TRUE(clipped.gyro[2]);
  EXPECT_FALSE(clipped.gyro[0] || clipped.gyro[1] || clipped.accel[2]);
  const StateCov P = grown(buffer);
  const StateCov usual = grown(turning(100.0, 100.0));
  EXPECT_GT(std::sqrt(P(kTheta + 2, kTheta + 2)), 0.09) << "what it turns too fast for";
  EXPECT_NEAR(P(kTheta, kTheta), usual(kTheta, kTheta), 1e-6);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(P(kVel + k, kVel + k), usual(kVel + k, kVel + k), 1e-4) << "it does not drive off";
  }
}

TEST(Inertial, a_saturated_accelerometer_increases_only_the_velocity_variance_along_its_axis) {
  const InertialBuffer buffer = turning(100.0, 11.0);
  EXPECT_TRUE(buffer.clipped(Time::from_s(0.9), Time::from_s(1.0)).accel[2]);
  const StateCov P = grown(buffer);
  EXPECT_GT(std::sqrt(P(kVel + 2, kVel + 2)), 0.3);
  EXPECT_LT(std::sqrt(P(kVel, kVel)), 0.02);
  EXPECT_LT(std::sqrt(P(kTheta + 2, kTheta + 2)), 0.002);
}

TEST(Inertial, a_sensor_within_its_range_is_not_clipped) {
  EXPECT_FALSE(turning(100.0, 100.0).clipped(Time{}, Time::from_s(1.0)).any());
}

}  // namespace
}  // namespace rali::odometry
