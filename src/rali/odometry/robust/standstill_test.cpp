#include "rali/odometry/robust/standstill.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/update.hpp"

namespace rali::odometry {
namespace {

using geometry::so3_exp;
using geometry::Vec3;

const Vec3 kTrueBias(0.004, -0.002, 0.006);

constexpr double kGyroNoise = 3e-3;
constexpr ProcessNoise kNoise{kGyroNoise, 0.03, 1e-5, 1e-4};

struct Recording {
  double push_mps2 = 0.0;
  InertialBuffer imu;
  FilterState state;
  Rng rng{1, "standstill"};
  Vec3 extra_gyro = Vec3::Zero();
  double shake_mps2 = 0.0, shake_hz = 2.0;
  double gyro_noise_radps = 0.005, accel_noise_mps2 = 0.03;

  Recording() {
    state.gyro_bias_radps = kTrueBias;
    state.P.diagonal().setConstant(1e-4);
  }

  void advance(double span_s) {
    const Time end = state.t + Duration::from_s(span_s);
    while (state.t < end) {
      state.t = state.t + Duration::from_s(0.005);
      const Vec3 noise(rng.normal(), rng.normal(), rng.normal());
      const double shake = shake_mps2 * std::sin(2.0 * std::numbers::pi * shake_hz * state.t.s());
      imu.add({state.t, kTrueBias + extra_gyro + gyro_noise_radps * noise,
               Vec3(push_mps2 + shake, 0.0, 9.81) + accel_noise_mps2 * noise});
    }
  }
};

/// Standstill from the start, with the noise given to the detector.
struct Standing {
  Recording r;
  StandstillDetector detector{{}, {}};

  explicit Standing(std::uint64_t seed, double accel_noise_mps2 = 0.03) {
    r.rng = Rng(seed, "standing");
    r.gyro_noise_radps = kGyroNoise / std::sqrt(0.005);
    r.accel_noise_mps2 = accel_noise_mps2;
    r.state.P.diagonal().setConstant(1e-8);
    r.advance(1.0);
    detector.learn(imu::statistics(r.imu.between(Time{}, r.state.t)));
    for (int k = 0; k < 20; ++k) static_cast<void>(step());
  }

  bool step() {
    r.advance(0.1);
    const bool stands = detector.update(r.state, r.imu, std::nullopt, kGyroNoise);
    r.imu.drop_before(r.state.t - Duration::from_s(2.0));
    return stands;
  }
};

bool stands_after(Recording& r, int scans, const Vec3& step_m = Vec3::Zero()) {
  StandstillDetector detector({}, {});
  bool stands = false;
  for (int k = 0; k < scans; ++k) {
    r.advance(0.1);
    r.state.T_odom_body.p += step_m;
    stands = detector.update(r.state, r.imu, std::nullopt, kGyroNoise);
  }
  return stands;
}

TEST(Standstill, is_detected_immediately_when_earlier_standstill_is_given) {
  Recording r;
  r.state.P.diagonal().setConstant(1e-8);
  r.advance(1.0);
  StandstillDetector waits({}, {}), knows({}, {});
  for (StandstillDetector* detector : {&waits, &knows}) {
    detector->learn(imu::statistics(r.imu.between(Time{}, r.state.t)));
  }
  knows.stood_since(Time{}, r.state.T_odom_body);
  EXPECT_FALSE(waits.update(r.state, r.imu, std::nullopt, kGyroNoise));
  EXPECT_TRUE(knows.update(r.state, r.imu, std::nullopt, kGyroNoise));
  r.push_mps2 = 1.0;
  r.advance(0.5);
  EXPECT_FALSE(knows.update(r.state, r.imu, std::nullopt, kGyroNoise)) << "it starts";
}

TEST(StandstillDetector, reports_the_inertial_noise_density_at_standstill) {
  StandstillDetector detector({}, {});
  EXPECT_FALSE(detector.rest_density());
  Recording r;
  r.advance(2.0);
  detector.learn(imu::statistics(r.imu.between(Time{}, r.state.t)));
  ASSERT_TRUE(detector.rest_density());
  EXPECT_NEAR(detector.rest_density()->accel_mps2_rthz, 0.03 * std::sqrt(0.005), 3e-4);
  EXPECT_NEAR(detector.rest_density()->gyro_radps_rthz, 0.005 * std::sqrt(0.005), 5e-5);
}

TEST(StandstillDetector, detects_standstill_only_after_its_time_window) {
  Recording r;
  EXPECT_FALSE(stands_after(r, 6));
  Recording s;
  EXPECT_TRUE(stands_after(s, 12));
}

TEST(StandstillDetector, detects_motion_by_speed_travel_rotation_and_vibration) {
  Recording fast;
  fast.state.v = Vec3(0.1, 0.0, 0.0);
  EXPECT_FALSE(stands_after(fast, 12));
  Recording creeping;  // 3 mm per scan
  EXPECT_FALSE(stands_after(creeping, 12, Vec3(0.003, 0.0, 0.0)));
  Recording turning;
  turning.extra_gyro = Vec3(0.0, 0.0, 0.05);
  EXPECT_FALSE(stands_after(turning, 12));
  Recording shaken;
  shaken.shake_mps2 = 1.0;
  EXPECT_FALSE(stands_after(shaken, 12));
}

TEST(StandstillDetector, does_not_detect_standstill_when_velocity_is_uncertain) {
  Recording degenerate;  // a corridor without end: the filter has no speed estimate
  degenerate.state.P.diagonal().segment<3>(kVel).setConstant(0.04);
  EXPECT_FALSE(stands_after(degenerate, 12));
}

// A tunnel from the first scan on, and a running engine: the sensor's noise at standstill is
// unknown. The filter drifts along the tunnel; all else is at standstill.
TEST(StandstillDetector, when_degenerate_15_s_without_lateral_motion_proves_standstill) {
  const auto stands_at_s = [](double steers_m) {
    Recording r;
    r.rng = Rng(3, "tunnel");
    r.accel_noise_mps2 = 0.4;
    r.state.v = Vec3(0.4, 0.0, 0.0);
    r.state.P.diagonal().segment<3>(kVel) = Vec3(1.0, 1e-4, 1e-4);
    StandstillDetector detector({}, {});
    for (int k = 1; k <= 300; ++k) {
      r.advance(0.1);
      r.state.T_odom_body.p = Vec3(0.04 * k, steers_m * std::sin(0.03 * k), 0.0);
      if (detector.update(r.state, r.imu, Vec3::UnitX(), kGyroNoise)) return 0.1 * k;
      r.imu.drop_before(r.state.t - Duration::from_s(detector.memory_s()));
    }
    return 1e9;
  };
  EXPECT_NEAR(stands_at_s(0.0), 15.1, 1.0);
  EXPECT_EQ(stands_at_s(0.1), 1e9);
}

TEST(StandstillDetector, when_degenerate_low_vibration_proves_standstill) {
  const auto rests = [](double shake_mps2, const Vec3& v, const Vec3& axis) {
    Recording r;
    StandstillDetector detector({}, {});
    r.advance(1.0);
    detector.learn(imu::statistics(r.imu.between(Time{}, r.state.t)));
    // The filter drifts along x with a large speed sigma.
    r.state.v = v;
    r.state.P.diagonal().segment<3>(kVel) = Vec3(1.0, 1e-4, 1e-4);
    r.shake_mps2 = shake_mps2;
    bool stands = false;
    for (int k = 0; k < 12; ++k) {
      r.advance(0.1);
      r.state.T_odom_body.p += 0.1 * v;
      stands = detector.update(r.state, r.imu, axis, kGyroNoise);
    }
    return stands;
  };
  EXPECT_TRUE(rests(0.0, {0.5, 0.0, 0.0}, Vec3::UnitX()));
  EXPECT_FALSE(rests(0.1, {0.5, 0.0, 0.0}, Vec3::UnitX())) << "it rolls";
  EXPECT_FALSE(rests(0.0, {0.0, 0.5, 0.0}, Vec3::UnitX())) << "the LiDAR sees it move";
}

TEST(StandstillDetector, imu_alone_proves_standstill_once_driving_has_shown_vibration) {
  const auto rests = [](double shake_driving_mps2, double shake_now_mps2, double shake_hz = 19.0) {
    Recording r;
    r.shake_hz = shake_hz;
    StandstillDetector detector({}, {});
    const auto step = [&](int scans) {
      bool stands = false;
      for (int k = 0; k < scans; ++k) {
        r.advance(0.1);
        r.state.T_odom_body.p += 0.1 * r.state.v;
        stands = detector.update(r.state, r.imu, std::nullopt, kGyroNoise);
      }
      return stands;
    };
    EXPECT_TRUE(step(40));
    r.state.v = Vec3(1.0, 0.0, 0.0);
    r.shake_mps2 = shake_driving_mps2;
    EXPECT_FALSE(step(40));
    // The LiDAR still shows motion against the wall beside it: a train that leaves, or a lost pose.
    r.shake_mps2 = shake_now_mps2;
    const bool stands = step(20);
    EXPECT_EQ(stands, detector.certain());
    return stands;
  };
  EXPECT_TRUE(rests(0.4, 0.0));
  EXPECT_FALSE(rests(0.4, 0.4)) << "it drives on";
  // At constant speed a vehicle on a smooth floor feels as little as at standstill.
  EXPECT_FALSE(rests(0.4, 0.0, 2.0)) << "turns and changes of speed are no shaking";
  EXPECT_FALSE(rests(0.0, 0.0)) << "this vehicle drives without shaking: the sensor proves nothing";
}

TEST(StandstillDetector, one_hour_of_standstill_has_at_most_3_false_starts) {
  Standing vehicle(1);
  ASSERT_TRUE(vehicle.step());
  int ends = 0;
  bool stood = true;
  for (int k = 0; k < 36000; ++k) {
    const bool stands = vehicle.step();
    ends += stood && !stands ? 1 : 0;
    stood = stands;
  }
  EXPECT_LE(ends, 3);  // one or fewer on average: in one of fifty hours
}

TEST(StandstillDetector, learned_sensor_noise_does_not_count_as_vibration) {
  // Means of 0.1 s spread by 0.2 m/s^2 from white noise, and 0.25 are allowed.
  Standing vehicle(2, 0.2 * std::sqrt(20.0));
  int stands = 0;
  for (int k = 0; k < 1000; ++k) stands += vehicle.step() ? 1 : 0;
  EXPECT_EQ(stands, 1000);
  vehicle.r.shake_mps2 = 2.0;
  for (int k = 0; k < 7; ++k) static_cast<void>(vehicle.step());
  EXPECT_FALSE(vehicle.step());
}

TEST(StandstillDetector, slow_turns_and_starts_end_standstill_within_1_s) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Standing turning(seed);
    turning.r.extra_gyro = Vec3(0.0, 0.0, 0.03);  // under two degrees per second
    bool stands = true;
    for (int k = 0; k < 10 && stands; ++k) stands = turning.step();
    EXPECT_FALSE(stands) << seed;
    Standing pushed(seed);
    pushed.r.push_mps2 = 0.3;
    stands = true;
    for (int k = 0; k < 10 && stands; ++k) stands = pushed.step();
    EXPECT_FALSE(stands) << seed;
    Standing creeping(seed);  // by the LiDAR
    creeping.r.state.v = Vec3(0.05, 0.0, 0.0);
    stands = true;
    for (int k = 0; k < 10 && stands; ++k) {
      creeping.r.state.T_odom_body.p += 0.1 * creeping.r.state.v;
      stands = creeping.step();
    }
    EXPECT_FALSE(stands) << seed;
  }
}

TEST(StandstillDetector, an_acceleration_of_0_4_m_per_s2_prevents_standstill) {
  const auto rests = [](double push_mps2) {
    Recording r;
    r.state.P.diagonal().segment<3>(kTheta).setConstant(1e-6);
    r.state.P.diagonal().segment<3>(kAccelBias).setConstant(1e-6);
    r.state.P.diagonal().segment<2>(kGravity).setConstant(1e-6);
    r.push_mps2 = push_mps2;
    return stands_after(r, 12);
  };
  EXPECT_TRUE(rests(0.0));
  EXPECT_TRUE(rests(0.05)) << "somebody leans on it";
  EXPECT_FALSE(rests(0.4));
}

TEST(StandstillDetector, can_be_switched_off) {
  ConstraintSettings off;
  off.standstill = false;
  StandstillDetector detector(off, {});
  Recording r;
  for (int k = 0; k < 12; ++k) {
    r.advance(0.1);
    EXPECT_FALSE(detector.update(r.state, r.imu, std::nullopt, kGyroNoise));
  }
}

TEST(PropagateHeld, keeps_the_pose_and_estimates_the_biases) {
  Recording r;
  r.advance(10.0);
  FilterState s;
  s.T_odom_body = {so3_exp(Vec3(0.0, 0.0, 1.0)), Vec3(3.0, -2.0, 0.5)};
  s.P.diagonal().segment<3>(kTheta).setConstant(1e-8);
  s.P.diagonal().segment<3>(kPos).setConstant(1e-6);
  s.P.diagonal().segment<3>(kVel).setConstant(1e-4);
  s.P.diagonal().segment<3>(kGyroBias).setConstant(1e-4);
  s.P.diagonal().segment<3>(kAccelBias).setConstant(1e-2);
  s.accel_bias_mps2 = Vec3(0.0, 0.0, 0.1);  // wrong: the sensor has none
  const FilterState before = s;
  for (int k = 1; k <= 100; ++k) {
    propagate_held(s, r.imu, Time::from_s(0.1 * k), kNoise);
    ASSERT_TRUE(s.P.allFinite());
  }
  EXPECT_EQ(s.t, Time::from_s(10.0));
  EXPECT_LT((s.T_odom_body.p - before.T_odom_body.p).norm(), 1e-12);
  EXPECT_LT(geometry::so3_log(before.T_odom_body.R.transpose() * s.T_odom_body.R).norm(), 1e-12);
  EXPECT_LT(s.v.norm(), 0.01);
  EXPECT_LT((s.gyro_bias_radps - kTrueBias).norm(), 1.5e-3);
  EXPECT_LT(std::abs(s.accel_bias_mps2.z()), 0.02);
  for (int k = kGyroBias; k < kAccelBias; ++k) EXPECT_LT(s.P(k, k), before.P(k, k));
  EXPECT_LT(s.P(kAccelBias + 2, kAccelBias + 2), before.P(kAccelBias + 2, kAccelBias + 2));
  EXPECT_NEAR(s.P(kPos, kPos), 1e-6, 1e-12);
}

TEST(PropagateHeld, gravity_absorbs_pose_tilt_and_follows_its_later_correction) {
  Recording r;
  r.advance(5.0);
  FilterState s;
  s.T_odom_body.R = so3_exp(Vec3(0.0, 0.003, 0.0));  // the pose is pitched, the vehicle is not
  s.P.diagonal().segment<3>(kTheta).setConstant(4e-6);
  s.P.diagonal().segment<2>(kGravity).setConstant(1e-4);
  for (int k = 1; k <= 50; ++k) propagate_held(s, r.imu, Time::from_s(0.1 * k), kNoise);
  const Vec3 left = s.T_odom_body.R * Vec3(0.0, 0.0, 9.81) + s.g_odom_mps2;
  EXPECT_LT(left.head<2>().norm(), 0.005) << "it would drive off with this acceleration";
  // The LiDAR corrects the pitch: gravity must follow, or that much acceleration appears.
  Eigen::Matrix<double, 3, kStateDim> H = Eigen::Matrix<double, 3, kStateDim>::Zero();
  H.block<3, 3>(0, kTheta).setIdentity();
  const Vec3 level(0.0, -0.003, 0.0);
  update_linear<3>(s, H, level, 1e-10 * geometry::Mat3::Identity());
  const Vec3 after = s.T_odom_body.R * Vec3(0.0, 0.0, 9.81) + s.g_odom_mps2;
  EXPECT_LT(after.head<2>().norm(), 0.005);
}

TEST(PropagateHeld, ignores_times_before_the_state) {
  Recording r;
  r.advance(1.0);
  FilterState s;
  s.t = Time::from_s(0.5);
  propagate_held(s, r.imu, Time::from_s(0.4), kNoise);
  EXPECT_EQ(s.t, Time::from_s(0.5));
}

}  // namespace
}  // namespace rali::odometry
