#include "rali/graph/pose_graph.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/base/internal_error.hpp"
#include "rali/graph/chain_for_test.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

SE3 at(double x, double y = 0.0, double z = 0.0) { return {geometry::Mat3::Identity(), {x, y, z}}; }

// Settings that iterate until nothing moves.
GraphSettings to_the_end() {
  GraphSettings settings;
  settings.cost_change_min = 0.0;
  settings.step_min_m = 1e-9;
  return settings;
}

// Step along x with `information_x`, other directions well constrained.
RelativePoseFactor step(Seq i, Seq j, double x_m, double information_x) {
  geometry::Vec6 information;
  information << 1e6, 1e6, 1e6, information_x, 1e4, 1e4;
  return {i, j, at(x_m), information.asDiagonal()};
}

RangeFactor range_to(std::uint64_t id, Seq i, const Vec3& p_map_m, double range_m, double sigma_m) {
  RangeFactor f;
  f.id = id;
  f.i = i;
  f.p_fixed_odom_m = p_map_m;
  f.range_m = range_m;
  f.sigma_m = sigma_m;
  return f;
}

// T19 of algorithms_fleet.md: a separator prior is not a fixed node.
TEST(pose_graph, separator_prior_yields_to_a_new_factor_as_computed_by_hand) {
  PoseGraph graph{GraphSettings{}};
  for (int k = 0; k < 3; ++k) graph.add_pose(at(k));
  graph.fix(0);
  graph.add(step(0, 1, 1.0, 100.0));
  graph.add(step(1, 2, 1.0, 100.0));
  graph.solve(10);
  graph.marginalise({1});
  EXPECT_FALSE(graph.contains(Seq{1}));
  EXPECT_NEAR(1.0 / graph.covariance(2)(3, 3), 50.0, 1e-6);
  graph.add(step(0, 2, 2.2, 100.0));
  graph.solve(10);
  EXPECT_NEAR(graph.pose(2).p.x(), 2.1333, 1e-4);
}

// T20: odometry 0.5 m, range 0.1 m.
TEST(pose_graph, counts_a_range_once_and_refuses_it_the_second_time) {
  PoseGraph graph{GraphSettings{}};
  graph.fix(graph.add_pose(at(0)));
  graph.add_pose(at(1));
  graph.add(step(0, 1, 1.0, 4.0));
  const RangeFactor range = range_to(9, 1, {100.0, 0.0, 0.0}, 99.0, 0.1);
  graph.add(range);
  EXPECT_NEAR(std::sqrt(graph.covariance(1)(3, 3)), 0.0981, 5e-5);
  EXPECT_TRUE(graph.contains_range(9));
  EXPECT_THROW(graph.add(range), InternalError) << "0.0700 m would be claimed";
  EXPECT_TRUE(graph.remove_range(9));
  EXPECT_THROW(graph.add(range), InternalError) << "removed, but used";
}

// Node 1 has sigma 1 m, the range 1 m: they meet halfway, and the bias absorbs its part.
TEST(pose_graph, range_between_vehicles_distributes_its_residual_over_pose_and_bias) {
  PoseGraph graph{GraphSettings{}};
  graph.fix(graph.add_pose(at(0)));
  graph.add_pose(at(10));
  geometry::Vec6 information;
  information << 1e6, 1e6, 1e6, 1.0, 1e4, 1e4;
  graph.add_pose_prior(1, at(10), information.asDiagonal());
  graph.add_bias(0, 0.0, 1.0);
  RangeFactor f = range_to(1, 0, Vec3::Zero(), 10.9, 1.0);
  f.other.emplace();
  f.other->i = 1;
  f.bias = 0;
  EXPECT_NEAR(graph.predict(f).variance_m2, 2.0, 1e-6);
  EXPECT_NEAR(graph.residual(f), -0.9, 1e-12);
  graph.add(f);
  graph.solve(20);
  EXPECT_NEAR(graph.pose(1).p.x(), 10.3, 1e-6);
  EXPECT_NEAR(graph.bias(0).mean, 0.3, 1e-6);
  EXPECT_NEAR(graph.bias(0).variance, 2.0 / 3.0, 1e-6);
  EXPECT_NEAR(graph.covariance(1)(3, 3), 2.0 / 3.0, 1e-6);
}

TEST(pose_graph, gravity_factor_levels_a_pose_and_leaves_heading_unobservable) {
  PoseGraph graph{to_the_end()};
  const Seq seq = graph.add_pose({geometry::so3_exp({0.05, -0.03, 0.7}), {1.0, 2.0, 3.0}});
  GravityFactor gravity;
  gravity.i = seq;
  graph.add(gravity);
  graph.solve(20);
  EXPECT_NEAR((graph.pose(seq).R.col(2) - Vec3::UnitZ()).norm(), 0.0, 1e-6);
  const Mat6 P = graph.covariance(seq);
  EXPECT_NEAR(std::sqrt(P(0, 0)), 8.7266e-3, 1e-6);
  EXPECT_GT(P(2, 2), 1e6) << "heading";
}

// A fleet of two: 20 nodes each, ranges between them, one loop, one bias.
struct Fleet {
  PoseGraph graph{GraphSettings{}};

  explicit Fleet(int seed) {
    Rng rng(static_cast<std::uint64_t>(seed), "fleet");
    graph.add_bias(0, 0.0, 0.15);
    for (Seq k = 0; k < 40; ++k) {
      const double x = k % 20;
      const double y = k < 20 ? 0.0 : 4.0;
      graph.add_pose({geometry::so3_exp(random_vec3(rng, 0.02)),
                      Vec3(x, y + std::sin(0.4 * x), 0.0) + random_vec3(rng, 0.05)});
      if (k % 20 == 0) {
        graph.add_pose_prior(k, at(x, y), 1e4 * Mat6::Identity());
        continue;
      }
      RelativePoseFactor f = step(k - 1, k, 1.0, 400.0);
      f.T_i_j.p.y() = std::sin(0.4 * x) - std::sin(0.4 * (x - 1.0)) + 0.02 * rng.normal();
      graph.add(f);
    }
    for (Seq k = 0; k < 20; ++k) {
      RangeFactor f = range_to(k, k, Vec3::Zero(), 4.0 + 0.1 * rng.normal(), 0.1);
      f.other.emplace();
      f.other->i = 20 + k;
      f.bias = 0;
      graph.add(f);
    }
    LoopFactor loop;
    loop.id = 1;
    loop.pose = step(3, 23, 0.0, 400.0);
    loop.pose.T_i_j.p.y() = 4.0;
    graph.add(loop);
    graph.solve_full();
  }
};

TEST(pose_graph, batch_covariances_of_a_fleet_equal_those_of_single_nodes) {
  Fleet fleet(1);
  const std::vector<Mat6> all = fleet.graph.covariances();
  ASSERT_EQ(all.size(), 40U);
  for (Seq k = 0; k < 40; k += 7) {
    EXPECT_LT((all[k] - fleet.graph.covariance(k)).norm(), 1e-9 * all[k].norm()) << k;
  }
}

TEST(pose_graph, joint_covariance_contains_both_marginals_and_the_cross_covariance) {
  Fleet fleet(2);
  const auto P = fleet.graph.covariance(7, 30);
  EXPECT_LT((P.topLeftCorner<6, 6>() - fleet.graph.covariance(7)).norm(), 1e-12);
  EXPECT_LT((P.bottomRightCorner<6, 6>() - fleet.graph.covariance(30)).norm(), 1e-12);
  EXPECT_GT((P.topRightCorner<6, 6>().norm()), 1e-5);
  fleet.graph.fix(7);
  const auto held = fleet.graph.covariance(7, 30);
  EXPECT_EQ((held.leftCols<6>().norm()), 0.0);
  EXPECT_LT(held(10, 10), P(10, 10)) << "what is tied to a fixed node is known better";
}

TEST(pose_graph, marginalisation_preserves_means_and_covariances_of_the_remaining_nodes) {
  Fleet fleet(3);
  PoseGraph& graph = fleet.graph;
  graph.solve(50);
  const PoseGraph full = graph;
  PoseGraph before = full;
  std::vector<Seq> round;
  for (Seq k = 0; k < 40; ++k) {
    if (k % 20 < 15 && k != 23) round.push_back(k);
  }
  graph.marginalise(round);
  EXPECT_EQ(graph.nodes().size(), 40 - round.size());
  EXPECT_TRUE(graph.contains_range(0)) << "marginalised, but used";
  EXPECT_NEAR(graph.cost(), before.cost(), 1e-6 * before.cost());
  for (const Seq k : {Seq{23}, Seq{18}, Seq{39}}) {
    const Mat6 P = before.covariance(k);
    EXPECT_LT((graph.covariance(k) - P).norm(), 1e-6 * P.norm()) << k;
  }
  EXPECT_NEAR(graph.bias(0).variance, before.bias(0).variance, 1e-8);
  graph.solve(10);
  EXPECT_LT(geometry::boxminus(graph.pose(39), before.pose(39)).norm(), 1e-4);
}

// The later part of the graph again, in another one: the result equals that with the earlier
// rounds.
TEST(pose_graph, continues_from_the_separator_prior_of_another_graph) {
  PoseGraph before{to_the_end()};
  for (int k = 0; k < 3; ++k) before.add_pose(at(k));
  before.fix(0);
  before.add_bias(4, 0.0, 0.2);
  before.add(step(0, 1, 1.0, 100.0));
  before.add(step(1, 2, 1.1, 100.0));
  RangeFactor range = range_to(1, 1, {9.0, 0.0, 0.0}, 8.2, 0.1);
  range.bias = 4;
  before.add(range);
  before.solve(50);
  PoseGraph whole = before;
  before.marginalise({0, 1});

  PoseGraph after{to_the_end()};
  after.add_pose(at(77.0));  // the separator prior's value counts
  after.add_bias(4, 0.0, 0.2);
  DensePrior prior = before.separator();
  ASSERT_EQ(prior.keyframes.size(), 1U);
  prior.keyframes[0].seq = 0;
  after.set_separator_prior(prior);
  EXPECT_NEAR(after.pose(0).p.x(), whole.pose(2).p.x(), 1e-12);
  EXPECT_NEAR(after.bias(4).variance, whole.bias(4).variance, 1e-9) << "the bias is known once";

  range = range_to(2, 2, {9.0, 0.0, 0.0}, 6.7, 0.1);
  range.bias = 4;
  whole.add(range);
  range.i = 0;
  after.add(range);
  whole.solve(50);
  after.solve(50);
  EXPECT_NEAR(after.pose(0).p.x(), whole.pose(2).p.x(), 1e-7);
  EXPECT_NEAR(after.covariance(0)(3, 3), whole.covariance(2)(3, 3), 1e-9);
  EXPECT_NEAR(after.bias(4).mean, whole.bias(4).mean, 1e-7);
  prior.H(0, 0) = std::numeric_limits<double>::quiet_NaN();
  PoseGraph other{to_the_end()};
  other.add_pose(at(0.0));
  EXPECT_THROW(other.set_separator_prior(prior), InternalError) << "its bias is not there";
}

TEST(pose_graph, marginalisation_adds_no_information_along_a_degenerate_step) {
  PoseGraph graph{GraphSettings{}};
  for (int k = 0; k < 3; ++k) graph.add_pose(at(k));
  graph.fix(0);
  graph.add(step(0, 1, 1.0, 0.0));
  graph.add(step(1, 2, 1.0, 100.0));
  graph.marginalise({1});
  EXPECT_GT(graph.covariance(2)(3, 3), 1e6) << "nothing knows x of node 1, so nothing x of 2";
  EXPECT_LT(graph.covariance(2)(4, 4), 0.1);
}

// A node with velocity between two poses.
TEST(pose_graph, mixes_poses_with_nodes_that_have_a_velocity) {
  PoseGraph graph{to_the_end()};
  graph.fix(graph.add_pose(at(0)));
  KeyframeState x;
  x.T_odom_body = at(1);
  graph.add_state(x);
  x.T_odom_body = at(2);
  graph.add_state(x);
  graph.add_pose(at(3));
  for (Seq k = 0; k < 3; ++k) graph.add(step(k, k + 1, 1.0, 1e4));
  InertialFactor inertial;
  inertial.i = 1;
  inertial.j = 2;
  inertial.duration_s = 0.5;
  inertial.dv_mps = {0.0, 0.0, 4.905};
  inertial.dp_m = {0.0, 0.0, 1.22625};
  inertial.covariance *= 1e-4;
  graph.add(inertial);
  EXPECT_TRUE(graph.solve(20).converged);
  EXPECT_NEAR(graph.state(1).v_odom_mps.x(), 2.0, 1e-3);
  EXPECT_NEAR(graph.pose(3).p.x(), 3.0, 1e-6);
  inertial.j = 3;
  EXPECT_THROW(graph.add(inertial), InternalError) << "a pose has no velocity";
}

TEST(pose_graph, same_calls_give_the_same_bytes) {
  Fleet a(4);
  Fleet b(4);
  for (Seq k = 0; k < 40; ++k) {
    EXPECT_EQ(a.graph.pose(k).p, b.graph.pose(k).p);
    EXPECT_EQ(a.graph.pose(k).R, b.graph.pose(k).R);
  }
  EXPECT_EQ(a.graph.covariances(), b.graph.covariances());
}

TEST(pose_graph, refuses_inconsistent_factors_and_marginalising_all_nodes) {
  PoseGraph graph{GraphSettings{}};
  graph.add_pose(at(0));
  graph.add_pose(at(1));
  EXPECT_THROW(graph.add(step(0, 7, 1.0, 1.0)), InternalError);
  RangeFactor range = range_to(1, 0, Vec3::Zero(), 1.0, 0.1);
  range.other.emplace();
  EXPECT_THROW(graph.add(range), InternalError) << "both ends on one node";
  EXPECT_FALSE(graph.contains_range(1)) << "refused, so not used";
  range.other->i = 1;
  range.range_m = std::nan("");
  EXPECT_THROW(graph.add(range), InternalError);
  StandstillFactor still;
  EXPECT_THROW(graph.add(still), InternalError) << "a pose alone cannot stand";
  LoopFactor loop{1, step(0, 1, 1.0, 1.0)};
  graph.add(loop);
  EXPECT_THROW(graph.add(loop), InternalError);
  EXPECT_THROW(graph.marginalise({0, 1}), InternalError) << "nothing would be left";
  EXPECT_EQ(PoseGraph(GraphSettings{}).solve_full().iterations, 0) << "nothing to solve";
}

}  // namespace
}  // namespace rali::graph
