#include "rali/graph/solver.hpp"

#include <gtest/gtest.h>

#include "rali/graph/chain_for_test.hpp"
#include "rali/graph/checks.hpp"
#include "rali/graph/global_equations.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/normal_equations.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

/// A way of 60 keyframes past so many places of others, each heard from three keyframes.
Window way_past(int places) {
  Rng rng(5, "way past");
  Window window;
  for (Seq k = 0; k < 60; ++k) {
    KeyframeNode node;
    node.seq = k;
    node.t = Time::from_s(k);
    node.x.T_odom_body.p = geometry::Vec3(2.0 * k, 0.0, 0.0) + random_vec3(rng, 0.05);
    window.keyframes.push_back(node);
    window.priors.push_back(with_root(window, pose_prior(k, {}, 10.0, {1e3, 1e3, 1e3})));
  }
  window.priors.front() = with_root(window, pose_prior(0, {}, 1e-4, {0.01, 0.01, 0.01}));
  for (Seq k = 1; k < 60; ++k) {
    const RelativePoseFactor f = relative(k - 1, k, {2.0, 0.0, 0.0}, {0.2, 0.01, 0.01});
    window.relative.push_back(with_root(window, f));
  }
  for (int n = 0; n < places; ++n) {
    insert_landmark(window, n, {2.0 * n, 4.0, 1.0}, 4.0 * geometry::Mat3::Identity());
    for (Seq k = 0; k < 3; ++k) {
      RangeFactor f = fixed_range(100 * n + k, std::min<Seq>(n + k, 59), {}, 4.3 + 0.2 * k, 0.1);
      f.t = Time::from_s(f.i);
      f.landmark = n;
      window.ranges.push_back(f);
    }
  }
  return window;
}

// Hundreds of places at which others stood make no band: the wide order must be the same equations.
TEST(solver, takes_the_same_way_whatever_the_order_of_elimination) {
  const LocalGraphSettings settings;
  Window by_band = way_past(50), by_fill = by_band, chosen = by_band;
  NormalEquations band(by_band, settings.huber_sd);
  GlobalEquations fill(by_fill, settings.huber_sd);
  EXPECT_LT((band.gradient() - fill.gradient()).norm(), 1e-9 * band.gradient().norm());
  const SolveReport a = levenberg_marquardt(by_band, band, steps_of(settings), 30);
  const SolveReport b = levenberg_marquardt(by_fill, fill, steps_of(settings), 30);
  const SolveReport c = solve(chosen, settings, 30);
  EXPECT_LT(a.cost_after, 0.5 * a.cost_before);
  EXPECT_NEAR(a.cost_after, b.cost_after, 1e-6 * a.cost_after);
  EXPECT_EQ(c.cost_after, b.cost_after) << "150 unknowns of landmarks: by least fill";
  EXPECT_EQ(c.iterations, a.iterations);
  for (std::size_t k = 0; k < by_band.keyframes.size(); ++k) {
    const geometry::Vec3 p = by_band.keyframes[k].x.T_odom_body.p;
    EXPECT_LT((p - chosen.keyframes[k].x.T_odom_body.p).norm(), 1e-6) << k;
  }
}

TEST(solver, keeps_the_band_for_a_few_landmarks) {
  const LocalGraphSettings settings;
  Window by_band = way_past(5), chosen = by_band;
  NormalEquations band(by_band, settings.huber_sd);
  const SolveReport a = levenberg_marquardt(by_band, band, steps_of(settings), 30);
  EXPECT_EQ(solve(chosen, settings, 30).cost_after, a.cost_after);
}

}  // namespace
}  // namespace rali::graph
