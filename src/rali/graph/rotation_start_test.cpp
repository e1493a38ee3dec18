#include "rali/graph/rotation_start.hpp"

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/graph/pose_graph.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr int kRing = 60;

std::vector<SE3> ring(Rng& rng) {
  std::vector<SE3> truth;
  for (int k = 0; k < kRing; ++k) {
    const double angle = 2.0 * M_PI * k / kRing;
    truth.push_back(
        {geometry::so3_exp({0.0, 0.0, angle}) * geometry::so3_exp(random_vec3(rng, 0.2)),
         {10.0 * std::cos(angle), 10.0 * std::sin(angle), 0.1 * k}});
  }
  return truth;
}

// A ring whose nodes have arbitrary initial poses; measurements are exact.
PoseGraph scattered(const std::vector<SE3>& truth, Rng& rng, bool hold) {
  PoseGraph graph{GraphSettings{}};
  for (std::size_t k = 0; k < truth.size(); ++k) {
    graph.add_pose(k == 0 ? truth[0]
                          : SE3{geometry::so3_exp(random_vec3(rng, 2.0)), random_vec3(rng, 20.0)});
  }
  if (hold) graph.fix(0);
  for (Seq k = 0; k < truth.size(); ++k) {
    const Seq next = (k + 1) % static_cast<Seq>(truth.size());
    graph.add(RelativePoseFactor{k, next, truth[k].inverse() * truth[next],
                                 geometry::Vec6(1e4, 2e4, 5e4, 100, 200, 100).asDiagonal()});
  }
  return graph;
}

double farthest(const PoseGraph& graph, const std::vector<SE3>& truth) {
  double error = 0.0;
  for (const KeyframeNode& node : graph.nodes()) {
    error = std::max(error, geometry::boxminus(node.x.T_odom_body, truth[node.seq]).norm());
  }
  return error;
}

TEST(rotation_start, recovers_a_ring_from_random_initial_poses) {
  Rng rng(1, "ring");
  const std::vector<SE3> truth = ring(rng);
  PoseGraph graph = scattered(truth, rng, true);
  const SolveReport report = graph.solve_full();
  EXPECT_TRUE(report.rotation_first);
  EXPECT_LT(report.cost_after, 1e-12);
  EXPECT_LT(farthest(graph, truth), 1e-6);
}

TEST(rotation_start, does_not_move_the_first_node_of_an_unanchored_graph) {
  Rng rng(2, "ring");
  const std::vector<SE3> truth = ring(rng);
  PoseGraph graph = scattered(truth, rng, false);
  graph.solve_full();
  EXPECT_LT(farthest(graph, truth), 1e-6);
}

TEST(rotation_start, is_skipped_when_the_initial_estimate_is_good) {
  Rng rng(3, "ring");
  const std::vector<SE3> truth = ring(rng);
  PoseGraph graph = scattered(truth, rng, true);
  graph.solve_full();
  EXPECT_FALSE(graph.solve_full().rotation_first);
}

// Two vehicles connected only by ranges: each part keeps its position.
TEST(rotation_start, solves_disconnected_components_independently) {
  Rng rng(4, "ring");
  const std::vector<SE3> truth = ring(rng);
  PoseGraph graph{GraphSettings{}};
  for (int v = 0; v < 2; ++v) {
    for (Seq k = 0; k < 5; ++k) {
      SE3 start = truth[k];
      if (k > 0) start = {geometry::so3_exp(random_vec3(rng, 2.0)), random_vec3(rng, 20.0)};
      start.p.z() += 5.0 * v;
      graph.add_pose(start);
    }
    for (Seq k = 0; k < 4; ++k) {
      graph.add(RelativePoseFactor{5U * static_cast<Seq>(v) + k, 5U * static_cast<Seq>(v) + k + 1,
                                   truth[k].inverse() * truth[k + 1],
                                   100.0 * geometry::Mat6::Identity()});
    }
  }
  graph.solve_full();
  for (Seq k = 0; k < 5; ++k) {
    EXPECT_LT(geometry::boxminus(graph.pose(k), truth[k]).norm(), 1e-6);
    SE3 upstairs = truth[k];
    upstairs.p.z() += 5.0;
    EXPECT_LT(geometry::boxminus(graph.pose(5 + k), upstairs).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace rali::graph
