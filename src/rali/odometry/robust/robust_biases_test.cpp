#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

// Bias updates beyond three sigma of their prior are contradictions, not biases.

namespace rali::odometry {
namespace {

FindingList refusals(const Driven& driven) {
  FindingList out;
  for (const Finding& f : driven.findings) {
    if (f.id == "odometry.bias_refused") out.push_back(f);
  }
  return out;
}

/// A force beyond the turn-on bias of any data sheet, from the start on.
constexpr double kPush_mps2 = 0.8;
constexpr int kStart = 16;  ///< scans until the vehicle drives off
constexpr double kLimit_mps2 = 3.0 * InitialisationSettings{}.accel_bias_sigma_mps2;

TEST(Biases, stay_within_3_sigma_while_inertial_noise_is_increased) {
  Driven driven(small_room(), kStart, true), undisturbed(small_room(), kStart, true);
  double max_mps2 = 0.0;
  ScanResult result;
  for (int k = 0; k < 40; ++k) {
    result = drive_pushed(driven, 1, kPush_mps2);
    max_mps2 = std::max(max_mps2, result.accel_bias_mps2.norm());
  }
  const imu::NoiseDensity calm = drive_pushed(undisturbed, 40, 0.0).inertial_noise;
  EXPECT_LE(max_mps2, kLimit_mps2);
  EXPECT_GT(max_mps2, 0.85 * kLimit_mps2) << "a part is attributed to gravity";
  EXPECT_GT(result.inertial_noise.accel_mps2_rthz, 2.0 * calm.accel_mps2_rthz);
  // The gyro shows only the contradiction: the joint graph receives the larger noise too.
  EXPECT_GT(result.inertial_noise.gyro_radps_rthz, 1.3 * calm.gyro_radps_rthz);
  const geometry::Vec3 off_m = result.T_odom_body.p - driven.room.pose(driven.t_end.s()).p;
  EXPECT_LT(off_m.norm(), 0.03) << "the LiDAR sees the motion";
}

TEST(Biases, report_each_refused_update_once_with_its_time_interval) {
  OdometrySettings settings;
  settings.imu_noise.accel_walk_mps3_rthz = 0.3;  // a wandering bias crosses its limit again
  Driven driven(small_room(), kStart, true, settings);
  const double start_s = driven.t_end.s();
  drive_pushed(driven, 30, kPush_mps2);
  const double end_s = driven.t_end.s();
  drive_pushed(driven, 60, 0.0);
  ASSERT_EQ(refusals(driven).size(), 1U);
  const Finding first = refusals(driven)[0];
  EXPECT_LT(first.t, first.t_end);
  EXPECT_GT(first.t.s(), start_s);
  EXPECT_LT(first.t_end.s(), end_s + 0.5);
  EXPECT_NE(first.text.find("accelerometer's"), std::string::npos) << first.text;
  drive_pushed(driven, 34, kPush_mps2);
  EXPECT_EQ(refusals(driven).size(), 1U) << "the second one goes on";
  driven.odometry->finish(driven.findings);
  ASSERT_EQ(refusals(driven).size(), 2U);
  EXPECT_GT(refusals(driven)[1].t, first.t_end);
  driven.odometry->finish(driven.findings);
  EXPECT_EQ(refusals(driven).size(), 2U);
}

TEST(Biases, of_a_good_sensor_are_never_refused) {
  Driven driven(small_room(), 60, true);
  driven.odometry->finish(driven.findings);
  EXPECT_TRUE(refusals(driven).empty());
}

// An accelerometer of 0.3 m/s2/rtHz, ten times the typical and claimed value. Before the vehicle
// has driven only standstill reveals it.
TEST(RestNoise, is_a_lower_bound_of_the_inertial_noise_used) {
  OdometrySettings settings;
  settings.robust.initialisation.rest.accel_sd_max_mps2 = 10.0;
  TestRoom noisy = small_room();
  noisy.accel_noise_mps2 = 4.2;  // per sample at 200 Hz
  noisy.rest_s = 100.0;
  for (const TestRoom& room : {small_room(), noisy}) {
    Driven driven(room, 0, true, settings);
    ScanResult result;
    while (!result.inertial && driven.scans < 40) result = driven.scan();
    result = driven.scan();
    ASSERT_TRUE(result.inertial);
    const double truth = room.accel_noise_mps2 * std::sqrt(0.005);
    EXPECT_GT(result.inertial_noise.accel_mps2_rthz, 0.8 * truth);
    EXPECT_LT(result.inertial_noise.accel_mps2_rthz, std::max(0.04, 2.0 * truth));
  }
}

}  // namespace
}  // namespace rali::odometry
