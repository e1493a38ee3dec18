#include "rali/sim/imu_model.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

double degrees(double rad) { return rad * 180.0 / M_PI; }

TEST(ImuModel, specific_force_at_standstill_points_up) {
  const sensor::ImuSample s = ideal_imu(Time{}, MotionState{}, SE3{});
  EXPECT_NEAR((s.accel_mps2 - Vec3(0.0, 0.0, 9.81)).norm(), 0.0, 1e-12);
  EXPECT_EQ(s.gyro_radps.norm(), 0.0);
}

TEST(ImuModel, rotation_gives_a_centripetal_acceleration_at_a_lever_arm) {
  MotionState state;
  state.omega_body_radps = {0.0, 0.0, 2.0};
  const sensor::ImuSample s =
      ideal_imu(Time{}, state, {geometry::Mat3::Identity(), {0.5, 0.0, 0.0}});
  EXPECT_NEAR(s.accel_mps2.x(), -2.0, 1e-12);  // -w^2 r
}

TEST(ImuModel, resonances_have_the_set_rms_while_driving_and_none_at_standstill) {
  ImuOptions o = ImuOptions::ideal();
  o.resonance_accel_mps2 = 0.15;
  o.resonance_gyro_radps = 0.02;
  ImuModel imu(o, 1);
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const sensor::ImuSample s = imu.measure({}, 1.0);
    gyro += s.gyro_radps.squaredNorm() / (3.0 * kCount);
    accel += s.accel_mps2.squaredNorm() / (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(accel), 0.15, 0.02);
  EXPECT_NEAR(std::sqrt(gyro), 0.02, 0.003);
  EXPECT_EQ(imu.measure({}, 0.0).accel_mps2.norm(), 0.0);
}

TEST(ImuModel, a_misaligned_triad_measures_a_horizontal_part_of_gravity) {
  ImuOptions o = ImuOptions::ideal();
  o.misalignment_deg = 1.0;
  ImuModel imu(o, 1);
  sensor::ImuSample level;
  level.accel_mps2 = {0.0, 0.0, 9.81};
  const Vec3 f = imu.measure(level, 0.0).accel_mps2;
  EXPECT_NEAR(f.norm(), 9.81, 1e-9);
  EXPECT_LE(degrees(std::acos(f.z() / f.norm())), 1.0 + 1e-6);
  EXPECT_GT(f.head<2>().norm(), 0.01);
}

TEST(ImuModel, white_noise_follows_the_density) {
  ImuOptions o = ImuOptions::ideal();
  o.gyro_radps_rthz = 1.5e-3;
  o.accel_mps2_rthz = 1e-2;
  ImuModel imu(o, 1);
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const sensor::ImuSample s = imu.measure({}, 0.0);
    gyro += s.gyro_radps.squaredNorm() / (3.0 * kCount);
    accel += s.accel_mps2.squaredNorm() / (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(gyro), 1.5e-3 * std::sqrt(200.0), 6e-4);
  EXPECT_NEAR(std::sqrt(accel), 1e-2 * std::sqrt(200.0), 4e-3);
}

TEST(ImuModel, vibration_is_proportional_to_speed_with_the_set_sigma) {
  ImuOptions o = ImuOptions::ideal();
  o.vibration_accel_mps2 = 0.3;
  ImuModel imu(o, 1);
  double squares = 0.0;
  constexpr int kCount = 8000;
  for (int i = 0; i < kCount; ++i) {
    squares += imu.measure({}, 2.0).accel_mps2.squaredNorm() / (3.0 * kCount);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.6, 0.03);
  EXPECT_EQ(imu.measure({}, 0.0).accel_mps2.norm(), 0.0);
}

TEST(ImuModel, unit_time_offset_scale_and_saturation_errors_are_applied) {
  ImuOptions o = ImuOptions::ideal();
  o.accel_in_g = true;
  o.gyro_in_degps = true;
  o.time_offset_s = 0.02;
  o.scale_error = 0.01;
  o.gyro_limit_radps = 1.0;
  sensor::ImuSample ideal;
  ideal.t = Time::from_s(1.0);
  ideal.accel_mps2 = {0.0, 0.0, 9.81};
  ideal.gyro_radps = {3.0, 0.5, 0.0};
  const sensor::ImuSample s = ImuModel(o, 1).measure(ideal, 0.0);
  EXPECT_NEAR(s.accel_mps2.z(), 1.01, 1e-12);
  EXPECT_NEAR(s.gyro_radps.x(), degrees(1.0), 1e-9);  // saturated
  EXPECT_NEAR(s.gyro_radps.y(), degrees(0.505), 1e-9);
  EXPECT_EQ(s.t, Time::from_s(1.02));
}

TEST(ImuModel, turn_on_biases_have_the_set_sigma) {
  ImuOptions o = ImuOptions::ideal();
  o.gyro_bias_radps = 0.003;
  o.accel_bias_mps2 = 0.03;
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kSensors = 1000;
  for (int seed = 0; seed < kSensors; ++seed) {
    const ImuModel imu(o, static_cast<std::uint64_t>(seed));
    gyro += imu.gyro_bias_radps().squaredNorm() / (3.0 * kSensors);
    accel += imu.accel_bias_mps2().squaredNorm() / (3.0 * kSensors);
  }
  const double tolerance = 4.0 / std::sqrt(2.0 * 3.0 * kSensors);
  EXPECT_NEAR(std::sqrt(gyro) / 0.003, 1.0, tolerance);
  EXPECT_NEAR(std::sqrt(accel) / 0.03, 1.0, tolerance);
}

TEST(ImuModel, bias_random_walk_grows_with_the_square_root_of_time) {
  ImuOptions o = ImuOptions::ideal();
  o.gyro_walk_radps2_rthz = 1e-4;
  o.accel_walk_mps3_rthz = 1e-3;
  double gyro = 0.0;
  double accel = 0.0;
  constexpr int kSensors = 300;
  for (int seed = 0; seed < kSensors; ++seed) {
    ImuModel imu(o, static_cast<std::uint64_t>(seed));
    for (int i = 0; i < 800; ++i) (void)imu.measure({}, 0.0);  // 4 s
    gyro += imu.gyro_bias_radps().squaredNorm() / (3.0 * kSensors);
    accel += imu.accel_bias_mps2().squaredNorm() / (3.0 * kSensors);
  }
  const double tolerance = 4.0 / std::sqrt(2.0 * 3.0 * kSensors);
  EXPECT_NEAR(std::sqrt(gyro) / (1e-4 * 2.0), 1.0, tolerance);
  EXPECT_NEAR(std::sqrt(accel) / (1e-3 * 2.0), 1.0, tolerance);
}

TEST(ImuModel, vibration_is_concentrated_around_40_hz) {
  ImuOptions o = ImuOptions::ideal();
  o.vibration_gyro_radps = 1.0;
  ImuModel imu(o, 3);
  constexpr int kCount = 4000;  // 20 s
  std::vector<double> x;
  for (int i = 0; i < kCount; ++i) x.push_back(imu.measure({}, 1.0).gyro_radps.x());
  const auto power = [&](double hz) {
    double c = 0.0;
    double s = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const double phase = 2.0 * M_PI * hz * i / o.rate_hz;
      c += x[static_cast<std::size_t>(i)] * std::cos(phase);
      s += x[static_cast<std::size_t>(i)] * std::sin(phase);
    }
    return c * c + s * s;
  };
  double near = 0.0;
  double far = 0.0;
  for (int k = 0; k < 20; ++k) {
    near += power(39.0 + 0.1 * k);
    far += power(5.0 + 0.1 * k) + power(85.0 + 0.1 * k);
  }
  EXPECT_GT(near, 20.0 * far);
}

}  // namespace
}  // namespace rali::sim
