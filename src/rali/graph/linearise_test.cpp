#include "rali/graph/linearise.hpp"

#include <gtest/gtest.h>

#include "rali/graph/derivatives_for_test.hpp"
#include "rali/graph/root.hpp"
#include "rali/graph/window_for_test.hpp"

namespace rali::graph {
namespace {

using geometry::SE3;
using geometry::Vec3;

TEST(inertial_factor, derivatives_agree_with_central_differences_with_an_imu_off_the_body) {
  Rng rng(1, "inertial");
  for (int k = 0; k < 5; ++k) {
    const Window window = random_window(rng);
    const InertialTerm term{random_inertial(rng), Eigen::Matrix<double, 9, 9>::Identity()};
    expect_derivatives(window,
                       [&](const Window& w, LinearFactor& out) { linearise(w, term, out); });
  }
}

// An IMU 1 m ahead of the body: a turn by a right angle moves it although the body's origin stays.
TEST(inertial_factor, position_residual_includes_the_lever_arm_of_the_imu) {
  Window window;
  window.keyframes.resize(2);
  window.keyframes[1].seq = 1;
  window.keyframes[1].x.T_odom_body.R = geometry::so3_exp({0.0, 0.0, 0.5 * M_PI});
  InertialTerm term{{}, Eigen::Matrix<double, 9, 9>::Identity()};
  term.f.j = 1;
  term.f.duration_s = 1.0;
  term.f.g_odom_mps2.setZero();
  term.f.T_body_imu.p = {1.0, 0.0, 0.0};
  term.f.dR = window.keyframes[1].x.T_odom_body.R;
  window.lay_out();
  LinearFactor out;
  linearise(window, term, out);
  EXPECT_NEAR((out.r.segment<3>(6) - Vec3(-1.0, 1.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(out.r.head<6>().norm(), 0.0, 1e-12);
}

TEST(relative_pose_factor, derivatives_agree_with_central_differences) {
  Rng rng(2, "relative");
  for (int k = 0; k < 5; ++k) {
    const Window window = random_window(rng);
    RelativeTerm term;
    term.f.i = 4;
    term.f.j = 5;
    term.f.T_i_j = {geometry::so3_exp(random_vec3(rng, 0.5)), random_vec3(rng, 2.0)};
    term.root = geometry::Vec6(1.0, 2.0, 0.5, 0.0, 1.0, 3.0).asDiagonal();
    expect_derivatives(window,
                       [&](const Window& w, LinearFactor& out) { linearise(w, term, out); });
  }
}

RangeFactor full_range(Rng& rng) {
  RangeFactor f;
  f.i = 4;
  f.j = 5;
  f.alpha = 0.3;
  f.p_i_m = random_vec3(rng, 0.5);
  f.p_j_m = random_vec3(rng, 0.5);
  f.landmark = 1;
  f.bias = 2;
  f.tau = 3;
  f.range_m = 6.0;
  f.sigma_m = 1.0;
  return f;
}

TEST(range_factor, derivatives_agree_with_central_differences_with_bias_tau_and_landmark) {
  Rng rng(3, "range");
  for (int k = 0; k < 5; ++k) {
    const Window window = random_window(rng);
    RangeFactor f = full_range(rng);
    const auto make = [&](const Window& w, LinearFactor& out) { linearise(w, f, 1e6, out); };
    expect_derivatives(window, make);
    f.range_rate_mps = -0.7;
    expect_derivatives(window, make);
    f = {};
    f.i = 5;
    f.p_i_m = {0.1, 0.2, 0.3};
    expect_derivatives(window, make);
  }
}

TEST(range_factor, gradient_of_the_robust_cost_is_that_of_the_weighted_residual) {
  Rng rng(4, "huber");
  const Window window = random_window(rng);
  RangeFactor f = full_range(rng);
  f.sigma_m = 0.1;
  f.weight = 0.5;
  LinearFactor out;
  linearise(window, f, 2.0, out);
  ASSERT_GT(out.cost, 4.0) << "not in the robust part";
  expect_derivatives(
      window, [&](const Window& w, LinearFactor& o) { linearise(w, f, 2.0, o); }, false);
}

// T3 of algorithms.md.
TEST(range_factor, agrees_with_the_numbers_worked_by_hand) {
  Window window;
  window.keyframes.resize(1);
  window.keyframes[0].x.T_odom_body = {geometry::so3_exp({0.1, -0.2, 0.7}), {3.0, -1.0, 0.4}};
  RangeFactor f;
  f.p_i_m = {0.2, 0.1, 0.5};
  f.p_fixed_odom_m = {-8.0, 0.5, 0.6};
  window.lay_out();
  LinearFactor out;
  range_residual(window, f, out);
  EXPECT_NEAR(out.r(0), 11.100814, 1e-6);
  EXPECT_NEAR((out.J.block<1, 3>(0, 0) - Eigen::RowVector3d(0.358424, 0.354293, -0.214228)).norm(),
              0.0, 2e-6);
  EXPECT_NEAR((out.J.block<1, 3>(0, 3) - Eigen::RowVector3d(0.991820, -0.124058, 0.030058)).norm(),
              0.0, 2e-6);
}

// Halfway between two keyframes the antenna is the mean of the positions predicted by both.
TEST(range_factor, interpolates_the_antenna_position_between_two_keyframes) {
  Window window;
  window.keyframes.resize(2);
  window.keyframes[1].seq = 1;
  window.keyframes[1].x.T_odom_body.p = {4.0, 0.0, 0.0};
  RangeFactor f;
  f.j = 1;
  f.alpha = 0.25;
  f.p_i_m = {1.2, 0.0, 0.0};   // odometry of i: 0.2 m too far
  f.p_j_m = {-3.0, 0.0, 0.0};  // odometry of j: exact
  window.lay_out();
  LinearFactor out;
  range_residual(window, f, out);
  EXPECT_NEAR(out.r(0), 0.75 * 1.2 + 0.25 * 1.0, 1e-12);
}

TEST(range_factor, has_no_derivative_and_no_nan_where_the_antennas_coincide) {
  Window window;
  window.keyframes.resize(1);
  RangeFactor f;
  f.range_m = 0.4;
  window.lay_out();
  LinearFactor out;
  linearise(window, f, 2.0, out);
  EXPECT_EQ(out.J.norm(), 0.0);
  EXPECT_TRUE(out.r.allFinite());
}

TEST(other_factors, standstill_prior_and_global_derivatives_agree_with_central_differences) {
  Rng rng(5, "others");
  for (int k = 0; k < 3; ++k) {
    const Window window = random_window(rng);
    StandstillFactor still;
    still.i = 4;
    still.next = 5;
    still.sigma_mps = still.sigma_m = still.sigma_rad = 1.0;
    expect_derivatives(window,
                       [&](const Window& w, LinearFactor& out) { linearise(w, still, out); });
    PriorTerm prior;
    prior.f.i = 4;
    prior.f.mean.T_odom_body = {geometry::so3_exp(random_vec3(rng, 0.8)), random_vec3(rng, 1.0)};
    prior.root = StateMat::Identity();
    expect_derivatives(window,
                       [&](const Window& w, LinearFactor& out) { linearise(w, prior, out); });
    for (const GlobalNode& global : window.globals) {
      expect_derivatives(window, [&](const Window& w, LinearFactor& out) {
        linearise(w, w.globals[static_cast<std::size_t>(w.find(global.id))], out);
      });
    }
  }
}

TEST(dense_prior, gradient_agrees_with_central_differences_away_from_its_linearisation_point) {
  Rng rng(6, "dense");
  Window window = random_window(rng);
  Window other = random_window(rng);
  window.dense.keyframes.push_back({5, other.keyframes[1].x});
  window.dense.globals.push_back({bias_id(2), other.globals[1].value});
  const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(16, 16, [&] { return rng.normal(); });
  window.dense.H = A.transpose() * A;
  window.dense.b = Eigen::VectorXd::NullaryExpr(16, [&] { return rng.normal(); });
  window.dense.cost = 3.0;
  const LinearPrior at = linearise(window, window.dense);
  for (const auto& block : at.blocks) {
    for (int d = 0; d < block.dim; ++d) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(window.columns());
      step(block.column + d) = 1e-6;
      Window plus = window;
      plus.move(step);
      Window minus = window;
      minus.move(-step);
      const double slope =
          (linearise(plus, window.dense).cost - linearise(minus, window.dense).cost) / 2e-6;
      EXPECT_NEAR(slope, at.gradient(block.local + d), 1e-6 * std::max(1.0, at.cost));
    }
  }
}

// A corridor along (1, 1, 0)/sqrt(2): observable across and up, degenerate along.
TEST(information_root, keeps_a_degenerate_direction_exactly_degenerate) {
  const Vec3 along = Vec3(1.0, 1.0, 0.0).normalized();
  geometry::Mat6 information = geometry::Mat6::Zero();
  information.topLeftCorner<3, 3>().diagonal().setConstant(1e7);
  information.bottomRightCorner<3, 3>() =
      4e4 * (geometry::Mat3::Identity() - along * along.transpose());
  const Eigen::MatrixXd W = information_root(information);
  EXPECT_LT((W.transpose() * W - information).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((W.rightCols(3) * along).norm(), 1e-10) << "sd of a blind metre beyond 1e10 m";
  EXPECT_EQ(information_root(geometry::Mat6::Zero()).norm(), 0.0);
}

TEST(covariance_root, inverts_mixed_units_and_bounds_the_information_of_zero_variance) {
  Eigen::Matrix2d covariance;
  covariance << 1e-12, 0.5e-6, 0.5e-6, 1.0;
  const Eigen::MatrixXd W = covariance_root(covariance);
  EXPECT_LT((W * covariance * W.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-8);
  const Eigen::MatrixXd exact = covariance_root(Eigen::Matrix2d::Zero());
  EXPECT_NEAR(exact(0, 0), 1e9, 1.0);
}

}  // namespace
}  // namespace rali::graph
