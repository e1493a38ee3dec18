#include "rali/odometry/robust/lift_ride.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

constexpr double kG = 9.81;

/// At rest, upright, an accelerometer known to 0.01 m/s2.
FilterState at_rest() {
  FilterState state;
  state.g_odom_mps2 = {0.0, 0.0, -kG};
  state.P.setZero();
  state.P.diagonal().segment<3>(kAccelBias).setConstant(1e-4);
  return state;
}

/// Feeds a constant upward acceleration for some time at 100 Hz.
class Cabin {
 public:
  explicit Cabin(double error_mps2 = 0.0) : error_mps2_(error_mps2) {
    ride.stand(Time::from_s(0.0));
    push(0.0, 1.1);
    EXPECT_TRUE(ride.stands());
  }

  void push(double accel_mps2, double span_s) {
    std::vector<sensor::ImuSample> samples;
    for (int k = 0; k < std::lround(100.0 * span_s); ++k) {
      sensor::ImuSample s;
      s.t = Time::from_s(0.01 * ++n_);
      s.accel_mps2 = {0.0, 0.0, kG + accel_mps2 + error_mps2_};
      samples.push_back(s);
    }
    ride.add(samples, at_rest(), 0.001);
  }

  LiftRide ride;

 private:
  double error_mps2_;
  int n_ = 0;
};

// 1 m/s2 for 2 s, 2 m/s for 1 s, and to rest again: 2 + 2 + 2 m.
TEST(LiftRide, measures_the_height_between_two_standstills) {
  Cabin cabin;
  cabin.push(1.0, 2.0);
  EXPECT_TRUE(cabin.ride.rides());
  EXPECT_NEAR(cabin.ride.height().up_m, 2.0, 0.02);
  cabin.push(0.0, 1.0);
  EXPECT_FALSE(cabin.ride.arrived()) << "no force, but 2 m/s";
  cabin.push(-1.0, 2.0);
  cabin.push(0.0, 1.1);
  ASSERT_TRUE(cabin.ride.arrived());
  EXPECT_NEAR(cabin.ride.height().up_m, 6.0, 0.03);
  EXPECT_LT(cabin.ride.height().sigma_m, 0.1);
}

TEST(LiftRide, the_speed_at_the_end_measures_a_constant_error_of_the_force) {
  Cabin cabin(0.02);
  cabin.push(-1.0, 2.0);
  cabin.push(1.0, 2.0);
  cabin.push(0.0, 1.1);
  ASSERT_TRUE(cabin.ride.arrived());
  EXPECT_NEAR(cabin.ride.height().up_m, -4.0, 0.03) << "and not 0.26 m more";
}

TEST(LiftRide, begins_only_after_a_standstill) {
  Cabin braking;
  braking.ride.stand(Time::from_s(1.1));
  braking.push(-3.0, 0.1);  // bounces: the speed before it is not known
  braking.push(0.0, 0.8);
  EXPECT_FALSE(braking.ride.rides());
  Cabin stands;
  stands.push(-3.0, 0.1);
  stands.push(0.0, 0.8);
  EXPECT_TRUE(stands.ride.rides());
}

TEST(LiftRide, a_small_lasting_error_of_the_force_is_no_ride) {
  Cabin cabin;
  cabin.push(0.1, 4.0);
  EXPECT_FALSE(cabin.ride.rides());
}

TEST(LiftRide, springs_that_yield_are_no_ride) {
  Cabin cabin;
  cabin.push(-2.0, 0.1);
  cabin.push(2.0, 0.1);
  cabin.push(0.0, 1.0);
  EXPECT_FALSE(cabin.ride.rides());
}

TEST(LiftRide, a_force_that_never_ends_is_an_error_of_the_sensor) {
  Cabin cabin;
  cabin.push(0.3, 28.0);
  EXPECT_FALSE(cabin.ride.is_sensor_error());
  cabin.push(0.3, 3.0);
  EXPECT_TRUE(cabin.ride.is_sensor_error());
  EXPECT_FALSE(cabin.ride.arrived());
}

TEST(LiftRide, removes_only_the_force_along_gravity) {
  std::vector<sensor::ImuSample> samples(1);
  samples[0].accel_mps2 = {0.2, -0.1, kG + 0.8};
  remove_lift(at_rest(), samples);
  EXPECT_TRUE(samples[0].accel_mps2.isApprox(geometry::Vec3(0.2, -0.1, kG), 1e-9));
}

}  // namespace
}  // namespace rali::odometry
