#include <cmath>
#include <cstring>
#include <numeric>

#include <gtest/gtest.h>

#include "rali/base/internal_error.hpp"
#include "rali/base/rng.hpp"
#include "rali/graph/chain_for_test.hpp"
#include "rali/graph/pose_graph.hpp"

namespace rali::graph {
namespace {

using geometry::Vec3;

GraphSettings exact_settings() {
  GraphSettings settings;
  settings.cost_change_min = 0.0;
  settings.step_min_m = 1e-9;
  return settings;
}

// T12 (a) of algorithms.md: three nodes, the range at the third.
PoseGraph three_nodes() {
  PoseGraph graph(exact_settings());
  for (Seq k = 0; k < 3; ++k) add_keyframe_at(graph, k, {5.0 * k, 0.0, 0.0});
  graph.add(pose_prior(0, {}, 1e-7, {0.01, 0.01, 1e-6}));
  for (Seq k = 0; k < 2; ++k) graph.add(relative(k, k + 1, {5.0, 0.0, 0.0}, {0.5, 0.02, 1e-6}));
  return graph;
}

RangeFactor range_at_third(std::uint64_t id) {
  return fixed_range(id, 2, {-10.0, 1.0, 0.0}, 20.6, 0.1);
}

TEST(pose_graph, solves_three_nodes_and_a_range_as_worked_by_hand) {
  PoseGraph graph = three_nodes();
  const RangePrediction before = graph.predict(range_at_third(1));
  const double nu = 20.6 - before.range_m;
  EXPECT_NEAR(nu, 0.575016, 1e-6);
  EXPECT_NEAR(before.variance_m2 + 0.01, 0.51, 0.002);
  EXPECT_NEAR(nu * nu / (before.variance_m2 + 0.01), 0.648, 0.003);
  graph.add(range_at_third(1));
  const SolveReport report = graph.solve(30);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(report.cost_after, 0.3249, 5e-5);
  EXPECT_NEAR(graph.state(1).T_odom_body.p.x(), 5.2823, 5e-5);
  EXPECT_NEAR(graph.state(2).T_odom_body.p.x(), 10.5644, 5e-5);
  EXPECT_NEAR(graph.state(1).T_odom_body.p.y(), 0.0, 1e-4);
  EXPECT_NEAR(graph.state(2).T_odom_body.p.y(), 0.0, 1e-4);
  EXPECT_NEAR(std::sqrt(graph.covariance(1)(3, 3)), 0.357, 5e-4);
  EXPECT_NEAR(std::sqrt(graph.covariance(2)(3, 3)), 0.099, 5e-4);
  EXPECT_NEAR(std::sqrt(graph.covariance(1)(4, 4)), 0.022, 5e-4);
  EXPECT_NEAR(std::sqrt(graph.covariance(2)(4, 4)), 0.030, 5e-4);
}

// T10 of algorithms.md: after an outage the correction is distributed in proportion to the growth
// of uncertainty, R = 0.01 m^2 of the range included.
TEST(pose_graph, distributes_a_range_correction_in_proportion_to_axial_variance_growth) {
  PoseGraph graph(exact_settings());
  const std::array<double, 5> variance = {0.01, 0.01, 0.04, 0.01, 0.03};
  add_keyframe_at(graph, 0, Vec3::Zero());
  graph.add(pose_prior(0, {}, 1e-7, Vec3::Constant(1e-6)));
  for (Seq k = 1; k <= 5; ++k) {
    add_keyframe_at(graph, k, {double(k), 0.0, 0.0});
    graph.add(relative(k - 1, k, {1.0, 0.0, 0.0}, {std::sqrt(variance[k - 1]), 0.01, 0.01}));
  }
  graph.add(fixed_range(1, 5, {105.0, 0.0, 0.0}, 99.5, 0.1));
  graph.solve(30);
  const std::array<double, 5> shared = {0.045455, 0.090909, 0.272727, 0.318182, 0.454545};
  for (Seq k = 1; k <= 5; ++k) {
    EXPECT_NEAR(graph.state(k).T_odom_body.p.x() - k, shared[k - 1], 1e-5);
  }
}

// 20 m and 20 m with LiDAR sigma 5 mm per keyframe, one degenerate link between: the ranges at the
// end move the second stretch as a whole, in a few steps.
TEST(pose_graph, range_correction_moves_only_the_keyframes_after_a_degenerate_link) {
  PoseGraph graph{GraphSettings{}};
  for (Seq k = 0; k <= 40; ++k) {
    add_keyframe_at(graph, k, {double(k), 0.0, 0.0});
    if (k == 0) graph.add(pose_prior(0, {}, 1e-3, Vec3::Constant(0.01)));
    const double sigma_m = k == 21 ? 0.5 : 0.005;
    if (k > 0) graph.add(relative(k - 1, k, {1.0, 0.0, 0.0}, {sigma_m, 0.005, 0.005}));
  }
  for (Seq k = 37; k <= 40; ++k) {
    graph.add(fixed_range(k, k, {-10.0, 0.0, 0.0}, 10.4 + k, 0.1));
  }
  const SolveReport report = graph.solve(5);
  EXPECT_TRUE(report.converged);
  // Chain sd 0.5 m and 4.5 cm against four ranges with sd 5 cm: 0.3960 m of 0.4 m are corrected.
  EXPECT_NEAR(graph.state(40).T_odom_body.p.x() - 40.0, 0.396, 1e-3);
  EXPECT_NEAR(graph.state(21).T_odom_body.p.x() - 21.0, 0.395, 2e-3);
  EXPECT_NEAR(graph.state(20).T_odom_body.p.x() - 20.0, 0.0, 2e-3);
}

// T12 (c): a range cannot separate axial sd 0.2 m from bias sd 0.1 m.
TEST(pose_graph, keeps_position_and_range_bias_correlated_as_computed_by_hand) {
  PoseGraph graph(exact_settings());
  add_keyframe_at(graph, 0, Vec3::Zero());
  graph.add(pose_prior(0, {}, 1e-7, {0.2, 1e-6, 1e-6}));
  graph.add_bias(0, 0.0, 0.1);
  RangeFactor range = fixed_range(1, 0, {-50.0, 0.0, 0.0}, 50.6, 0.1);
  range.bias = 0;
  EXPECT_NEAR(graph.predict(range).variance_m2 + 0.01, 0.06, 1e-8);
  graph.add(range);
  graph.solve(30);
  EXPECT_NEAR(graph.state(0).T_odom_body.p.x(), 0.4, 1e-6) << "gain 2/3";
  EXPECT_NEAR(graph.bias(0).mean, 0.1, 1e-6) << "gain 1/6";
  EXPECT_NEAR(graph.covariance(0)(3, 3), 0.013333, 1e-6) << "not 0.0894^2: the bias counts";
  EXPECT_NEAR(graph.bias(0).variance, 0.008333, 1e-6);
  // P_xx + 2 P_xb + P_bb with P_xb = -0.006667: predicted variance of a repeated range.
  RangeFactor again = range;
  again.id = 2;
  EXPECT_NEAR(graph.predict(again).variance_m2, 0.013333 - 2.0 * 0.006667 + 0.008333, 2e-6);
}

// Prior sd 1 m, range sd 0.1 m, the same measurement `uses` times under different ids: mean error
// for a given error of prior and range.
double error_of(int uses, double prior_error_m, double range_error_m, double* variance = nullptr) {
  PoseGraph graph(exact_settings());
  KeyframeState mean;
  mean.T_odom_body.p.x() = prior_error_m;
  graph.add_state(mean);
  graph.add(pose_prior(0, mean, 1e-7, {1.0, 1e-6, 1e-6}));
  for (int k = 0; k < uses; ++k) {
    graph.add(fixed_range(static_cast<std::uint64_t>(k), 0, {-1000.0, 0.0, 0.0},
                          1000.0 + range_error_m, 0.1));
  }
  graph.solve(30);
  if (variance != nullptr) *variance = graph.covariance(0)(3, 3);
  return graph.state(0).T_odom_body.p.x();
}

// T12 (d): if a measurement is used twice, the claimed variance is half the true one.
TEST(pose_graph, claims_half_the_true_variance_if_a_range_is_used_twice) {
  for (const int uses : {1, 2}) {
    double claimed = 0.0;
    const double by_prior = error_of(uses, 0.1, 0.0, &claimed) / 0.1;
    const double by_range = error_of(uses, 0.0, 0.1) / 0.1;
    const double truth = by_prior * by_prior + 0.01 * by_range * by_range;
    EXPECT_NEAR(std::sqrt(claimed), uses == 1 ? 0.0995037 : 0.070535, 1e-5);
    EXPECT_NEAR(std::sqrt(truth), uses == 1 ? 0.0995037 : 0.099627, 1e-5);
    EXPECT_NEAR(truth / claimed, uses == 1 ? 1.0 : 2.0, 0.02);
  }
}

TEST(pose_graph, refuses_a_range_id_it_has_used_before) {
  PoseGraph graph = three_nodes();
  EXPECT_FALSE(graph.contains_range(9));
  graph.add(range_at_third(9));
  EXPECT_TRUE(graph.contains_range(9));
  EXPECT_THROW(graph.add(range_at_third(9)), InternalError);
  EXPECT_TRUE(graph.remove_range(9));
  EXPECT_FALSE(graph.remove_range(9));
  EXPECT_THROW(graph.add(range_at_third(9)), InternalError) << "removed, but used";
  EXPECT_EQ(graph.range_count(), 0U);
}

TEST(pose_graph, refuses_factors_with_missing_variables_or_nan_values) {
  PoseGraph graph = three_nodes();
  RangeFactor range = range_at_third(1);
  range.bias = 4;
  EXPECT_THROW(graph.add(range), InternalError);
  range = range_at_third(1);
  range.range_m = NAN;
  EXPECT_THROW(graph.add(range), InternalError);
  range = range_at_third(1);
  range.alpha = 0.5;
  EXPECT_THROW(graph.add(range), InternalError) << "half way to no keyframe";
  EXPECT_THROW(graph.add(relative(2, 3, Vec3::Zero(), Vec3::Ones())), InternalError);
  EXPECT_THROW(add_keyframe_at(graph, 3, Vec3::Constant(NAN)), InternalError);
  EXPECT_FALSE(graph.contains_range(1));
}

// No factor at all, a floating chain, a degenerate axis: huge but finite variances, and no step.
TEST(pose_graph, reports_huge_variance_and_takes_no_step_along_unconstrained_directions) {
  PoseGraph graph(exact_settings());
  add_keyframe_at(graph, 0, {1.0, 2.0, 3.0});
  graph.solve(5);
  EXPECT_TRUE(graph.covariance(0).allFinite());
  EXPECT_GT(graph.covariance(0).diagonal().minCoeff(), 1e6);
  EXPECT_EQ(graph.state(0).T_odom_body.p, Vec3(1.0, 2.0, 3.0));

  for (Seq k = 1; k < 60; ++k) {
    add_keyframe_at(graph, k, {1.0 + k, 2.0, 3.0});
    graph.add(relative(k - 1, k, {1.01, 0.0, 0.0}, {0.0, 0.005, 0.005}));
  }
  graph.solve(20);
  const geometry::Mat6 P = graph.covariance(59);
  ASSERT_TRUE(P.allFinite());
  EXPECT_GT(P(3, 3), 1e6) << "blind along x";
  EXPECT_GT(P(4, 4), 1e4) << "floats in y";
  EXPECT_LT((graph.state(59).T_odom_body.p - Vec3(60.0, 2.0, 3.0)).norm(), 1e-3);
  std::vector<Seq> all_but_ten(50);
  std::iota(all_but_ten.begin(), all_but_ten.end(), Seq{0});
  graph.marginalise(all_but_ten);
  graph.solve(5);
  EXPECT_GT(graph.covariance(59)(3, 3), 1e6);
  EXPECT_LT((graph.state(59).T_odom_body.p - Vec3(60.0, 2.0, 3.0)).norm(), 1e-3);
}

// With a landmark and a bias that all ranges share, and a prior from what was marginalised.
TEST(pose_graph, batch_covariances_equal_single_ones_after_marginalisation) {
  PoseGraph graph = three_nodes();
  graph.add_landmark(1, {20.0, 3.0, 1.0}, 0.01 * geometry::Mat3::Identity());
  graph.add_bias(1, 0.0, 0.15);
  for (Seq k = 3; k < 12; ++k) {
    add_keyframe_at(graph, k, {5.0 * k, 0.0, 0.0});
    graph.add(relative(k - 1, k, {5.0, 0.0, 0.0}, {0.5, 0.02, 1e-6}));
    RangeFactor range = fixed_range(k, k, Vec3::Zero(), 5.0 * std::abs(k - 4.0) + 1.0, 0.1);
    range.landmark = 1;
    range.bias = 1;
    graph.add(range);
  }
  graph.marginalise({0});
  graph.solve(30);
  const std::vector<geometry::Mat6> all = graph.covariances();
  ASSERT_EQ(all.size(), graph.nodes().size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const geometry::Mat6 one = graph.covariance(graph.nodes()[k].seq);
    EXPECT_LT((all[k] - one).norm(), 1e-8 * one.norm()) << k;
  }
}

TEST(pose_graph, huber_loss_limits_the_effect_of_one_long_range) {
  PoseGraph graph = three_nodes();
  for (std::uint64_t id = 0; id < 10; ++id) {
    RangeFactor range = range_at_third(id);
    range.range_m = id == 0 ? 25.0 : std::sqrt(401.0);
    graph.add(range);
  }
  graph.solve(30);
  // Least squares: 0.5 m. Huber at 2 sd: 2 x 0.1 m / 9, less the effect of the chain (0.7 m).
  EXPECT_NEAR(graph.state(2).T_odom_body.p.x(), 10.0 + 0.2 / 9.0, 2e-4);
}

TEST(pose_graph, standstill_factor_zeroes_velocity_and_holds_the_pose) {
  PoseGraph graph(exact_settings());
  KeyframeState x;
  x.v_odom_mps = {0.3, 0.0, 0.0};
  graph.add_state(x);
  add_keyframe_at(graph, 1, {0.2, 0.1, 0.4});
  graph.add(StandstillFactor{0, 1});
  graph.add(pose_prior(0, {}, 0.01, {0.1, 0.1, 0.02}));
  graph.solve(20);
  EXPECT_LT(graph.state(0).v_odom_mps.norm(), 1e-6);
  EXPECT_LT(graph.pose(1).p.norm(), 1e-4);
  EXPECT_NEAR(std::sqrt(graph.covariance(1)(5, 5)), std::hypot(0.02, 0.003), 1e-5);
}

TEST(pose_graph, ranges_and_marginalisation_are_bitwise_reproducible) {
  const auto run = [] {
    PoseGraph graph = three_nodes();
    for (std::uint64_t id = 0; id < 7; ++id) graph.add(range_at_third(id));
    graph.solve(5);
    graph.marginalise({0});
    graph.solve(5);
    return std::pair(graph.pose(2).p, graph.covariance(2));
  };
  const auto a = run();
  const auto b = run();
  EXPECT_EQ(std::memcmp(a.first.data(), b.first.data(), sizeof(Vec3)), 0);
  EXPECT_EQ(std::memcmp(a.second.data(), b.second.data(), sizeof(geometry::Mat6)), 0);
}

}  // namespace
}  // namespace rali::graph
