#include "rali/fleet/centre/joint_covariance.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

Mat6 diagonal(double rad, double m) {
  Mat6 P = Mat6::Zero();
  P.diagonal().head<3>().setConstant(rad * rad);
  P.diagonal().tail<3>().setConstant(m * m);
  return P;
}

TEST(JointCovariance, equals_the_odometry_covariance_where_the_graph_adds_nothing) {
  const Mat6 steps = diagonal(2e-3, 0.05), map = diagonal(1e-3, 0.02);
  EXPECT_LT((joint_covariance(steps, steps, map) - map).norm(), 1e-9);
}

TEST(JointCovariance, adds_the_frame_covariance_but_not_the_step_covariance) {
  const Mat6 frame = diagonal(0.02, 0.2), steps = diagonal(2e-3, 0.05), map = diagonal(1e-3, 0.02);
  EXPECT_LT((joint_covariance(frame + steps, steps, map) - frame - map).norm(), 1e-9);
}

TEST(JointCovariance, includes_the_noise_of_ranges_that_deform_the_path) {
  // Steps of 0.05 m and ranges of 0.05 m: half of each, 0.025 m of noise from the ranges.
  Mat6 graph = diagonal(2e-3, 0.05), steps = graph, map = diagonal(1e-3, 0.02);
  graph.diagonal().tail<3>() *= 0.5;
  const Mat6 P = joint_covariance(graph, steps, map);
  EXPECT_NEAR(P(3, 3), map(3, 3) + 0.025 * 0.025, 1e-9);
  EXPECT_NEAR(P(2, 2), map(2, 2), 1e-12);
  // The steps contribute almost nothing: all is the variance of the bending measurements.
  graph.diagonal().tail<3>() *= 0.01;
  EXPECT_NEAR(joint_covariance(graph, steps, map)(3, 3), map(3, 3) + graph(3, 3),
              0.01 * graph(3, 3));
}

TEST(JointCovariance, is_that_of_the_graph_alone_in_a_degenerate_direction) {
  Mat6 graph = diagonal(2e-3, 0.05), steps = graph, map = diagonal(1e-3, 0.02);
  graph(3, 3) = 4.0;
  steps(3, 3) = map(3, 3) = 0.0;
  Mat6 expected = map;
  expected(3, 3) = 4.0;
  EXPECT_LT((joint_covariance(graph, steps, map) - expected).norm(), 1e-6);
}

/// Five steps of 1 m along x; the LiDAR observes all directions, or all except x.
VehiclePath straight(bool sees_x) {
  VehiclePath path(VehicleId{0});
  for (std::uint32_t k = 0; k <= 5; ++k) {
    Increment step;
    step.node = k;
    step.begins = k == 0;
    step.keyframe = k;
    step.T_odom_body.p = Vec3(k, 0.0, 0.0);
    step.lidar_information.setIdentity();
    step.lidar_information *= 1e12;
    if (!sees_x) step.lidar_information(3, 3) = 0.0;
    path.add(Time::from_s(k), step);
  }
  return path;
}

TEST(JointCovariance, of_steps_accumulates_with_their_lever_arms) {
  JointSettings settings;
  settings.shape.shape_m = 0.01;
  settings.shape.shape_rad = 1e-3;
  const auto P = shape_covariances(straight(true), settings);
  ASSERT_EQ(P.size(), 6U);
  EXPECT_LT(P[0].norm(), 1e-15);
  EXPECT_NEAR(P[1](3, 3), 1e-4, 1e-9);
  EXPECT_NEAR(P[5](3, 3), 5e-4, 1e-9);
  EXPECT_NEAR(P[5](2, 2), 5e-6, 1e-10);
  // Lateral: five shifts, and rotations 4, 3, 2, 1 and 0 m before the end.
  EXPECT_NEAR(P[5](4, 4), 5e-4 + 1e-6 * (16 + 9 + 4 + 1), 1e-8);
  const auto degenerate = shape_covariances(straight(false), settings);
  EXPECT_LT(degenerate[5](3, 3), 1e-12) << "the graph ties nothing there";
  EXPECT_NEAR(degenerate[5](4, 4), P[5](4, 4), 1e-8);
}

}  // namespace
}  // namespace rali::fleet
