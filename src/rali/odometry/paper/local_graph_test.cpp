#include "rali/odometry/paper/local_graph.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::odometry::paper {
namespace {

using geometry::Mat6;
using geometry::Vec3;
using geometry::Vec6;

/// One second without inertial data after a start in motion. Position: 2 m/s of unknown speed and
/// 2 m/s2 of unknown acceleration make 4 + 1 = 5 m2.
LocalGraph after_a_degenerate_second() {
  LocalGraph graph{ImuNoiseSettings{}};
  graph.reset(Vec3::UnitZ(), false);
  graph.advance_degenerate(1.0);
  return graph;
}

TEST(LocalGraph, starts_with_small_yaw_and_position_and_larger_tilt_variance) {
  LocalGraph graph{ImuNoiseSettings{}};
  graph.reset(Vec3::UnitZ(), true);
  const Mat6 P = graph.pose_covariance();
  EXPECT_NEAR(P(0, 0), 25e-6, 1e-12);
  EXPECT_NEAR(P(1, 1), 25e-6, 1e-12);
  EXPECT_NEAR(P(2, 2), 1e-8, 1e-14);
  EXPECT_NEAR(P(3, 3), 1e-8, 1e-14);
}

TEST(LocalGraph, covariance_grows_with_unknown_velocity_and_acceleration) {
  const Mat6 P = after_a_degenerate_second().pose_covariance();
  EXPECT_NEAR(P(3, 3), 5.0, 1e-6);
  EXPECT_NEAR(P(0, 0), 0.05 * 0.05 + 0.25, 1e-9);
}

TEST(LocalGraph, fuses_a_registration_like_a_kalman_filter) {
  // Prior 5 m2, information 20 /m2 at 0.5 m: variance 1/(1/5 + 20) = 0.049505 m2, step 0.49505 m;
  // speed follows by its correlation 4/5.
  LocalGraph graph = after_a_degenerate_second();
  Mat6 information = Mat6::Zero();
  information(3, 3) = 20.0;
  Vec6 pull = Vec6::Zero();
  pull[3] = 10.0;
  imu::InertialState state;
  imu::InertialBias bias;
  graph.add_registration(information, pull, state, bias);
  EXPECT_NEAR(state.p_odom_m.x(), 0.495050, 1e-6);
  EXPECT_NEAR(state.v_odom_mps.x(), 0.396040, 1e-6);
  EXPECT_NEAR(graph.pose_covariance()(3, 3), 0.049505, 1e-6);
}

TEST(LocalGraph, leaves_directions_without_registration_information_unchanged) {
  LocalGraph graph = after_a_degenerate_second();
  Mat6 information = Mat6::Zero();
  information(3, 3) = 20.0;
  Vec6 pull = Vec6::Zero();
  pull[3] = 10.0;
  imu::InertialState state;
  imu::InertialBias bias;
  graph.add_registration(information, pull, state, bias);
  EXPECT_EQ(state.p_odom_m.y(), 0.0);
  EXPECT_NEAR(graph.pose_covariance()(4, 4), 5.0, 1e-6);
}

TEST(LocalGraph, keeps_the_state_when_the_gradient_is_nan) {
  LocalGraph graph = after_a_degenerate_second();
  Vec6 pull = Vec6::Constant(std::numeric_limits<double>::quiet_NaN());
  imu::InertialState state;
  state.p_odom_m = Vec3(1.0, 2.0, 3.0);
  imu::InertialBias bias;
  graph.add_registration(Mat6::Identity(), pull, state, bias);
  EXPECT_EQ(state.p_odom_m, Vec3(1.0, 2.0, 3.0));
}

TEST(LocalGraph, corrects_velocity_through_its_correlation_with_position) {
  // Prior 5 m2, correlated with the speed by 4; a range of 5 m2 moved it by 1 m: S = 10, speed 0.4
  // m/s.
  LocalGraph graph = after_a_degenerate_second();
  imu::InertialState state;
  imu::InertialBias bias;
  graph.know_along(Vec3::UnitX(), 1.0, 5.0, state, bias);
  EXPECT_NEAR(state.v_odom_mps.x(), 0.4, 1e-6);
  EXPECT_EQ(state.p_odom_m.x(), 0.0) << "whoever measured has moved it";
  EXPECT_NEAR(graph.pose_covariance()(3, 3), 2.5, 1e-6);
  EXPECT_NEAR(graph.pose_covariance()(4, 4), 5.0, 1e-6);
}

TEST(LocalGraph, position_variance_does_not_grow_during_one_minute_of_standstill) {
  LocalGraph graph = after_a_degenerate_second();
  graph.start_standstill();
  EXPECT_NEAR(graph.covariance()(3, 3), 0.03 * 0.03, 1e-12);
  for (int k = 0; k < 600; ++k) {
    graph.advance_degenerate(0.1);
    graph.stay();
  }
  EXPECT_NEAR(graph.pose_covariance()(3, 3), 5.0, 1e-6);
}

}  // namespace
}  // namespace rali::odometry::paper
