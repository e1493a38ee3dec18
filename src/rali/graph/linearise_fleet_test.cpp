// Factors that only the graph of a fleet has, and poses without velocity.
#include "rali/graph/derivatives_for_test.hpp"
#include "rali/graph/root.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

using geometry::Vec3;

// Four keyframes of random_window's kind: 4 and 5, 6 and 7; bias 2 and tau 3.
Window two_vehicles(Rng& rng, int dim) {
  Window window = random_window(rng);
  const Window other = random_window(rng);
  for (KeyframeNode node : other.keyframes) {
    node.seq += 2;
    node.x.T_odom_body.p += Vec3(8.0, 1.0, 0.5);
    window.keyframes.push_back(node);
  }
  for (KeyframeNode& node : window.keyframes) node.dim = dim;
  window.lay_out();
  return window;
}

RangeFactor range_between(Rng& rng) {
  RangeFactor f;
  f.i = 4;
  f.j = 5;
  f.alpha = 0.3;
  f.p_i_m = random_vec3(rng, 0.5);
  f.p_j_m = random_vec3(rng, 0.5);
  f.other.emplace();
  f.other->i = 7;
  f.other->j = 6;
  f.other->alpha = 0.8;
  f.other->p_i_m = random_vec3(rng, 0.5);
  f.other->p_j_m = random_vec3(rng, 0.5);
  f.bias = 2;
  f.tau = 3;
  f.range_m = 6.0;
  f.sigma_m = 1.0;
  return f;
}

TEST(range_between_vehicles, derivatives_agree_with_central_differences) {
  Rng rng(1, "between");
  for (int k = 0; k < 5; ++k) {
    RangeFactor f = range_between(rng);
    const auto make = [&](const Window& w, LinearFactor& out) { linearise(w, f, 1e6, out); };
    expect_derivatives(two_vehicles(rng, kStateDim), make);
    f.range_rate_mps = -0.7;
    expect_derivatives(two_vehicles(rng, kPoseDim), make);
    f.j.reset();
    f.alpha = 0.0;
    f.other->j.reset();
    f.other->alpha = 0.0;
    f.tau.reset();
    expect_derivatives(two_vehicles(rng, kPoseDim), make);
  }
}

// Antennas 0.5 m above one body and 1 m ahead of the other, which is turned by a right angle.
TEST(range_between_vehicles, is_measured_from_antenna_to_antenna) {
  Window window;
  window.keyframes.resize(2);
  window.keyframes[1].seq = 1;
  window.keyframes[1].x.T_odom_body = {geometry::so3_exp({0.0, 0.0, 0.5 * M_PI}), {3.0, 3.0, 0.5}};
  RangeFactor f;
  f.p_i_m = {0.0, 0.0, 0.5};
  f.other.emplace();
  f.other->i = 1;
  f.other->p_i_m = {1.0, 0.0, 0.0};
  window.lay_out();
  LinearFactor out;
  range_residual(window, f, out);
  EXPECT_NEAR(out.r(0), 5.0, 1e-12);
}

TEST(gravity_factor, derivatives_agree_with_central_differences) {
  Rng rng(2, "gravity");
  for (int k = 0; k < 5; ++k) {
    GravityFactor f;
    f.i = 5;
    f.up_body = random_vec3(rng, 1.0).normalized();
    f.sigma_rad = 1.0;
    expect_derivatives(two_vehicles(rng, kPoseDim),
                       [&](const Window& w, LinearFactor& out) { linearise(w, f, out); });
  }
}

// Rolled by 0.1 rad, left side up: the accelerometer at standstill shows the same tilt.
TEST(gravity_factor, residual_is_zero_when_body_tilt_matches_the_accelerometer) {
  Window window;
  window.keyframes.resize(1);
  window.keyframes[0].x.T_odom_body.R = geometry::so3_exp({0.1, 0.0, 0.0});
  GravityFactor f;
  f.up_body = {0.0, std::sin(0.1), std::cos(0.1)};
  window.lay_out();
  LinearFactor out;
  linearise(window, f, out);
  EXPECT_NEAR(out.r.norm(), 0.0, 1e-12);
}

TEST(loop_term, scales_cost_and_derivatives_by_its_weight) {
  Rng rng(3, "loop");
  const Window window = two_vehicles(rng, kPoseDim);
  LoopTerm loop;
  loop.term.f.i = 4;
  loop.term.f.j = 7;
  loop.term.root = geometry::Vec6(1.0, 2.0, 0.5, 0.0, 1.0, 3.0).asDiagonal();
  EXPECT_EQ(rank(loop.term), 5) << "blind in one direction";
  LinearFactor whole;
  linearise(window, loop, whole);
  loop.weight = 0.25;
  LinearFactor quarter;
  linearise(window, loop, quarter);
  EXPECT_NEAR(quarter.cost, 0.25 * whole.cost, 1e-12);
  expect_derivatives(window, [&](const Window& w, LinearFactor& out) { linearise(w, loop, out); });
}

TEST(pose_nodes, accept_standstill_and_prior_factors_without_velocity_and_bias) {
  Rng rng(4, "pose");
  const Window window = two_vehicles(rng, kPoseDim);
  StandstillFactor still;
  still.i = 4;
  still.next = 5;
  still.sigma_m = still.sigma_rad = 1.0;
  const auto stands = [&](const Window& w, LinearFactor& out) { linearise(w, still, out); };
  LinearFactor at;
  stands(window, at);
  EXPECT_EQ(at.r.size(), 6);
  expect_derivatives(window, stands);
  PriorTerm prior;
  prior.f.i = 4;
  prior.f.mean.v_odom_mps = {1e3, 0.0, 0.0};  // irrelevant for a pose
  prior.root = StateMat::Identity();
  expect_derivatives(window, [&](const Window& w, LinearFactor& out) { linearise(w, prior, out); });
}

TEST(fixed_nodes, have_no_columns_and_do_not_move) {
  Rng rng(5, "fixed");
  Window window = two_vehicles(rng, kPoseDim);
  window.keyframes[1].fixed = true;
  window.lay_out();
  EXPECT_EQ(window.columns(), 3 * 6 + 3 + 1 + 1);
  EXPECT_EQ(window.column(5), -1);
  EXPECT_EQ(window.column(6), 6);
  const Vec3 before = window.keyframes[1].x.T_odom_body.p;
  window.move(Eigen::VectorXd::Ones(window.columns()));
  EXPECT_EQ(window.keyframes[1].x.T_odom_body.p, before);
  RelativeTerm term;
  term.f.i = 4;
  term.f.j = 5;
  term.root.setIdentity();
  expect_derivatives(window, [&](const Window& w, LinearFactor& out) { linearise(w, term, out); });
}

}  // namespace
}  // namespace rali::graph
