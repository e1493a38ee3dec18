#include "rali/ranging/range_model.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

using geometry::SE3;
using geometry::Vec3;
using Row3 = RangePrediction::Row3;

constexpr double kNear = 0.3;

/// The two ends of test T3.
RangeEnd end_j() {
  RangeEnd j;
  j.T_odom_body = {geometry::so3_exp(Vec3(0.1, -0.2, 0.7)), Vec3(3.0, -1.0, 0.4)};
  j.p_body_antenna_m = Vec3(0.2, 0.1, 0.5);
  return j;
}

RangeEnd end_k() {
  RangeEnd k;
  k.T_odom_body.p = Vec3(-8.0, 0.5, 0.0);
  k.p_body_antenna_m = Vec3(0.0, 0.0, 0.6);
  return k;
}

RangeEnd turned(RangeEnd end, const Vec3& theta) {
  end.T_odom_body.R = end.T_odom_body.R * geometry::so3_exp(theta);
  return end;
}

RangeEnd moved(RangeEnd end, const Vec3& d) {
  end.T_odom_body.p += d;
  return end;
}

/// Central differences of a range by a small vector.
Row3 differences(const std::function<double(const Vec3&)>& rho) {
  constexpr double kStep = 1e-5;
  Row3 out;
  for (int i = 0; i < 3; ++i) {
    const Vec3 d = kStep * Vec3::Unit(i);
    out(i) = (rho(d) - rho(-d)) / (2.0 * kStep);
  }
  return out;
}

double rho_of(const RangeEnd& j, const RangeEnd& k) { return predict(j, k, kNear)->rho_m; }

// Test T3 of the design.
TEST(RangeModel, matches_hand_computed_values) {
  const auto p = predict(end_j(), end_k(), kNear);
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->rho_m, 11.100814, 1e-6);
  EXPECT_LT((p->e - Vec3(0.991820, -0.124058, 0.030058)).norm(), 1e-6);
  EXPECT_LT((p->d_theta_j - Row3(0.358424, 0.354293, -0.214228)).norm(), 1e-6);
  EXPECT_EQ(p->d_p_j, Row3(p->e.transpose()));
  EXPECT_EQ(p->d_p_k, Row3(-p->e.transpose()));
  EXPECT_EQ(p->rate_mps, 0.0);
}

TEST(RangeModel, derivatives_match_central_differences) {
  RangeEnd k = end_k();
  k.T_odom_body.R = geometry::so3_exp(Vec3(-0.3, 0.2, 2.5));
  const RangeEnd j = end_j();
  const auto p = predict(j, k, kNear);
  ASSERT_TRUE(p);
  const auto close = [](const Row3& a, const Row3& b) { return (a - b).norm() < 1e-8; };
  EXPECT_TRUE(close(p->d_theta_j, differences([&](auto& d) { return rho_of(turned(j, d), k); })));
  EXPECT_TRUE(close(p->d_theta_k, differences([&](auto& d) { return rho_of(j, turned(k, d)); })));
  EXPECT_TRUE(close(p->d_p_j, differences([&](auto& d) { return rho_of(moved(j, d), k); })));
  EXPECT_TRUE(close(p->d_p_k, differences([&](auto& d) { return rho_of(j, moved(k, d)); })));
}

TEST(RangeModel, range_rate_matches_a_finite_difference_with_both_ends_moving) {
  RangeEnd j = end_j();
  RangeEnd k = end_k();
  j.v_odom_mps = Vec3(1.2, -0.4, 0.1);
  j.w_body_radps = Vec3(0.1, 0.3, -0.8);
  k.v_odom_mps = Vec3(0.2, 0.9, 0.0);
  k.w_body_radps = Vec3(0.0, 0.5, 1.1);
  const auto at = [](const RangeEnd& end, double dt_s) {
    return moved(turned(end, end.w_body_radps * dt_s), end.v_odom_mps * dt_s);
  };
  constexpr double kStep = 1e-5;
  const double by_steps =
      (rho_of(at(j, kStep), at(k, kStep)) - rho_of(at(j, -kStep), at(k, -kStep))) / (2.0 * kStep);
  EXPECT_NEAR(predict(j, k, kNear)->rate_mps, by_steps, 1e-8);
}

TEST(RangeModel, treats_a_landmark_as_an_end_that_does_not_move) {
  RangeEnd j = end_j();
  j.v_odom_mps = Vec3(1.0, 0.0, 0.0);
  const auto to_vehicle = predict(j, end_k(), kNear);
  const auto to_place = predict(j, end_k().antenna_odom_m(), kNear);
  ASSERT_TRUE(to_vehicle && to_place);
  EXPECT_EQ(to_place->rho_m, to_vehicle->rho_m);
  EXPECT_EQ(to_place->d_theta_j, to_vehicle->d_theta_j);
  EXPECT_EQ(to_place->d_p_k, to_vehicle->d_p_k);
  EXPECT_EQ(to_place->d_theta_k, Row3(Row3::Zero()));
  EXPECT_EQ(to_place->rate_mps, to_vehicle->rate_mps);
}

TEST(RangeModel, exchanging_the_ends_exchanges_the_derivatives) {
  const auto jk = predict(end_j(), end_k(), kNear);
  const auto kj = predict(end_k(), end_j(), kNear);
  EXPECT_NEAR(jk->rho_m, kj->rho_m, 1e-12);
  EXPECT_LT((jk->d_theta_j - kj->d_theta_k).norm(), 1e-12);
  EXPECT_LT((jk->e + kj->e).norm(), 1e-12);
}

TEST(RangeModel, antennas_that_nearly_touch_have_no_direction) {
  RangeEnd j;
  RangeEnd k;
  EXPECT_FALSE(predict(j, k, kNear));
  EXPECT_FALSE(predict(j, k, 0.0));
  k.T_odom_body.p.x() = 0.299;
  EXPECT_FALSE(predict(j, k, kNear));
  k.T_odom_body.p.x() = 0.301;
  EXPECT_TRUE(predict(j, k, kNear));
}

TEST(RangeModel, predicts_nothing_for_a_nan_or_infinite_pose) {
  RangeEnd j = end_j();
  j.T_odom_body.p.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(predict(j, end_k(), kNear));
  j.T_odom_body.p.y() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(predict(j, end_k(), kNear));
}

TEST(RangeModel, sigma_grows_with_the_distance) {
  const RangeLimits limits;
  EXPECT_NEAR(sigma_of(0.0, limits, 0.0), 0.1, 1e-12);
  EXPECT_NEAR(sigma_of(100.0, limits, 0.0), std::sqrt(0.02), 1e-12);
}

TEST(RangeModel, uses_the_sigma_of_the_sample_unless_it_is_implausible) {
  const RangeLimits limits;
  EXPECT_EQ(sigma_of(20.0, limits, 0.25), 0.25);
  EXPECT_EQ(sigma_of(20.0, limits, 1e-9), limits.sigma_min_m);
  const double own = sigma_of(20.0, limits, 0.0);
  EXPECT_EQ(sigma_of(20.0, limits, -1.0), own);
  EXPECT_EQ(sigma_of(20.0, limits, std::nan("")), own);
}

}  // namespace
}  // namespace rali::ranging
