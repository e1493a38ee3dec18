#include "rali/graph/marginalise.hpp"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/graph/chain_for_test.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

using geometry::Vec3;

// T12 (b) of algorithms.md; b is minus the right side.
TEST(eliminate_first, agrees_with_the_numbers_worked_by_hand) {
  Quadratic in;
  in.H = (Eigen::Matrix3d() << 5.0, -1.0, 0.0, -1.0, 3.0, -2.0, 0.0, -2.0, 2.0).finished();
  in.b = Vec3(-1.0, 0.0, 1.0);
  const Quadratic out = eliminate_first(in, 1);
  EXPECT_LT((out.H - (Eigen::Matrix2d() << 2.8, -2.0, -2.0, 2.0).finished()).norm(), 1e-12);
  EXPECT_LT((out.b + Eigen::Vector2d(0.2, -1.0)).norm(), 1e-12);
  EXPECT_LT((out.H.inverse() * -out.b - Eigen::Vector2d(-1.0, -1.5)).norm(), 1e-12);
  // The least cost of the three unknowns is that of the two that are left.
  const Vec3 x(0.0, -1.0, -1.5);
  const Eigen::Vector2d y = x.tail<2>();
  EXPECT_NEAR(in.b.dot(x) + 0.5 * x.dot(in.H * x), out.cost + out.b.dot(y) + 0.5 * y.dot(out.H * y),
              1e-12);
}

TEST(eliminate_first, drops_a_direction_that_nothing_holds_and_inflates_nothing) {
  Quadratic in;
  in.H = Eigen::Vector3d(0.0, 4.0, 9.0).asDiagonal();
  in.b = Vec3(0.0, 2.0, 3.0);
  const Quadratic out = eliminate_first(in, 2);
  EXPECT_EQ(out.H(0, 0), 9.0);
  EXPECT_EQ(out.b(0), 3.0);
}

TEST(drop_rounding, takes_out_negative_information_and_the_pull_along_it) {
  Quadratic q;
  q.H = Eigen::Vector2d(1e6, -1e-9).asDiagonal();
  q.b = Eigen::Vector2d(5.0, 1e-7);
  drop_rounding(q);
  EXPECT_NEAR(q.H(0, 0), 1e6, 1e-6);
  EXPECT_EQ(q.H(1, 1), 0.0);
  EXPECT_NEAR(q.b(0), 5.0, 1e-12);
  EXPECT_EQ(q.b(1), 0.0);
}

// A straight drive along x, known in y and z, with ranges to a landmark far ahead: nearly linear.
// `keep`: marginalise until so many keyframes are left each time.
LocalGraph drive_straight(std::size_t keep, double relax_variance = 0.0) {
  LocalGraphSettings settings;
  settings.cost_change_min = 0.0;
  settings.step_min_m = 1e-9;
  settings.huber_sd = 1e6;
  LocalGraph graph(settings);
  Rng rng(3, "straight");
  graph.add_landmark(0, {1000.0, 3.0, 0.0}, geometry::Mat3::Identity() * 0.04);
  graph.add_bias(0, 0.0, 0.1);
  for (Seq k = 0; k < 12; ++k) {
    add_keyframe_at(graph, k, {k + 0.05 * rng.normal(), 0.0, 0.0});
    if (k == 0) graph.add(pose_prior(0, {}, 1e-4, {0.01, 0.01, 0.01}));
    if (k > 0) {
      graph.add(relative(k - 1, k, {1.0 + 0.05 * rng.normal(), 0.0, 0.0}, {0.05, 0.01, 0.01}));
    }
    // Registration against an older keyframe as well: the prior then reaches two keyframes on.
    if (k > 1) {
      graph.add(relative(k - 2, k, {2.0 + 0.1 * rng.normal(), 0.0, 0.0}, {0.1, 0.02, 0.02}));
    }
    RangeFactor range = fixed_range(k, k, {}, 1000.0 - k + 0.1 * rng.normal(), 0.1);
    range.landmark = 0;
    range.bias = 0;
    if (k > 3) graph.add(range);
    if (relax_variance > 0.0) graph.relax(bias_id(0), relax_variance);
    graph.solve(20);
    while (graph.keyframes().size() > keep) graph.marginalise_oldest();
  }
  graph.solve(20);
  return graph;
}

TEST(marginalise_oldest, gives_the_newest_keyframe_of_the_full_graph_on_a_straight_drive) {
  LocalGraph full = drive_straight(100);
  LocalGraph window = drive_straight(3);
  ASSERT_EQ(window.keyframes().size(), 3U);
  for (Seq k = 9; k < 12; ++k) {
    EXPECT_LT(geometry::boxminus(full.state(k).T_odom_body, window.state(k).T_odom_body).norm(),
              2e-5);
    const geometry::Mat6 P = full.covariance(k);
    EXPECT_LT((P - window.covariance(k)).cwiseAbs().maxCoeff(), 1e-3 * P.diagonal().maxCoeff());
  }
  EXPECT_NEAR(full.bias(0).mean, window.bias(0).mean, 2e-5);
  EXPECT_NEAR(full.bias(0).variance, window.bias(0).variance, 1e-6);
  EXPECT_LT((full.landmark(0).covariance - window.landmark(0).covariance).norm(), 1e-5);
  EXPECT_NEAR(full.cost(), window.cost(), 1e-3 * full.cost());
}

TEST(marginalise_oldest, takes_a_retired_landmark_along_with_the_last_keyframe_that_knows_it) {
  LocalGraph graph{LocalGraphSettings{}};
  graph.add_landmark(7, {30.0, 0.0, 0.0}, geometry::Mat3::Identity());
  for (Seq k = 0; k < 4; ++k) {
    add_keyframe_at(graph, k, {double(k), 0.0, 0.0});
    if (k == 0) graph.add(pose_prior(0, {}, 1e-3, Vec3::Constant(0.01)));
    if (k > 0) graph.add(relative(k - 1, k, {1.0, 0.0, 0.0}, Vec3::Constant(0.02)));
    if (k > 1) continue;
    RangeFactor range = fixed_range(k, k, {}, 30.0 - k, 0.1);
    range.landmark = 7;
    graph.add(range);
  }
  graph.retire(landmark_id(7));
  graph.solve(5);
  const geometry::Mat6 before = graph.covariance(3);
  graph.marginalise_oldest();
  EXPECT_TRUE(graph.contains(landmark_id(7))) << "keyframe 1 has a range to it";
  graph.marginalise_oldest();
  EXPECT_FALSE(graph.contains(landmark_id(7)));
  EXPECT_LT((graph.covariance(3) - before).cwiseAbs().maxCoeff(), 1e-6 * before.maxCoeff());
}

// Bias of variance 0.01 that wanders by 0.02 has variance 0.03, before and after it is in the
// dense prior, and nothing else changes.
TEST(relax, adds_the_variance_of_the_walk_and_leaves_the_rest_alone) {
  LocalGraph graph{LocalGraphSettings{}};
  graph.add_bias(0, 0.3, 0.1);
  graph.relax(bias_id(0), 0.02);
  for (Seq k = 0; k < 2; ++k) add_keyframe_at(graph, k, Vec3::Zero());
  EXPECT_NEAR(graph.bias(0).variance, 0.03, 1e-9);
  graph.add(pose_prior(0, {}, 1e-3, Vec3::Constant(0.1)));
  graph.add(relative(0, 1, Vec3::Zero(), Vec3::Constant(0.01)));
  RangeFactor range = fixed_range(1, 0, {50.0, 0.0, 0.0}, 50.4, 0.1);
  range.bias = 0;
  graph.add(range);
  graph.solve(10);
  graph.marginalise_oldest();
  const double variance = graph.bias(0).variance;
  const double mean = graph.bias(0).mean;
  const geometry::Mat6 P = graph.covariance(1);
  graph.relax(bias_id(0), 0.02);
  graph.solve(10);
  EXPECT_NEAR(graph.bias(0).variance, variance + 0.02, 1e-6);
  EXPECT_NEAR(graph.bias(0).mean, mean, 1e-6);
  EXPECT_LT((graph.covariance(1) - P).cwiseAbs().maxCoeff(), 1e-7);
}

}  // namespace
}  // namespace rali::graph
