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

TEST(drop_rounding, removes_negative_information_and_the_gradient_along_it) {
  Quadratic q;
  q.H = Eigen::Vector2d(1e6, -1e-9).asDiagonal();
  q.b = Eigen::Vector2d(5.0, 1e-7);
  drop_rounding(q);
  EXPECT_NEAR(q.H(0, 0), 1e6, 1e-6);
  EXPECT_EQ(q.H(1, 1), 0.0);
  EXPECT_NEAR(q.b(0), 5.0, 1e-12);
  EXPECT_EQ(q.b(1), 0.0);
}

// A straight drive along x, with y and z known, and ranges to a landmark far ahead: nearly linear.
// `keep`: number of keyframes that remain after each marginalisation.
PoseGraph drive_straight(std::size_t keep) {
  GraphSettings settings;
  settings.cost_change_min = 0.0;
  settings.step_min_m = 1e-9;
  settings.huber_sd = 1e6;
  PoseGraph graph(settings);
  Rng rng(3, "straight");
  graph.add_landmark(0, {1000.0, 3.0, 0.0}, geometry::Mat3::Identity() * 0.04);
  graph.add_bias(0, 0.0, 0.1);
  for (Seq k = 0; k < 12; ++k) {
    add_keyframe_at(graph, k, {k + 0.05 * rng.normal(), 0.0, 0.0});
    if (k == 0) graph.add(pose_prior(0, {}, 1e-4, {0.01, 0.01, 0.01}));
    if (k > 0) {
      graph.add(relative(k - 1, k, {1.0 + 0.05 * rng.normal(), 0.0, 0.0}, {0.05, 0.01, 0.01}));
    }
    // Registration against an older keyframe as well: the prior then extends two keyframes ahead.
    if (k > 1) {
      graph.add(relative(k - 2, k, {2.0 + 0.1 * rng.normal(), 0.0, 0.0}, {0.1, 0.02, 0.02}));
    }
    RangeFactor range = fixed_range(k, k, {}, 1000.0 - k + 0.1 * rng.normal(), 0.1);
    range.landmark = 0;
    range.bias = 0;
    if (k > 3) graph.add(range);
    graph.solve(20);
    while (graph.nodes().size() > keep) graph.marginalise({graph.nodes().front().seq});
  }
  graph.solve(20);
  return graph;
}

TEST(marginalise, keeps_estimates_and_covariances_of_the_full_graph_on_a_straight_drive) {
  PoseGraph full = drive_straight(100);
  PoseGraph window = drive_straight(3);
  ASSERT_EQ(window.nodes().size(), 3U);
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

}  // namespace
}  // namespace rali::graph
