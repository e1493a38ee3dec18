#include "rali/odometry/robust/update.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/patches_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;

StateCov random_covariance(Rng& rng) {
  StateCov A;
  for (int i = 0; i < A.size(); ++i) A.data()[i] = 0.05 * rng.normal();
  return A * A.transpose();
}

template <int D>
void expect_textbook_update(Rng& rng) {
  FilterState s;
  s.P = random_covariance(rng);
  Eigen::Matrix<double, D, kStateDim> H;
  for (int i = 0; i < H.size(); ++i) H.data()[i] = rng.normal();
  Eigen::Matrix<double, D, 1> residual;
  for (int i = 0; i < D; ++i) residual[i] = 0.1 * rng.normal();
  const Eigen::Matrix<double, D, D> noise = 0.04 * Eigen::Matrix<double, D, D>::Identity();
  // Textbook in information form, as an independent computation.
  const StateCov P = (s.P.inverse() + H.transpose() * H / 0.04).inverse();
  const StateVec delta = P * H.transpose() * residual / 0.04;
  FilterState expected = s;
  add_error(expected, delta);
  update_linear<D>(s, H, residual, noise);
  EXPECT_LT((s.P - P).norm(), 1e-7 * P.norm());
  EXPECT_LT((s.T_odom_body.p - expected.T_odom_body.p).norm(), 1e-7);
  EXPECT_LT((s.T_odom_body.R - expected.T_odom_body.R).norm(), 1e-7);
  EXPECT_LT((s.v - expected.v).norm(), 1e-7);
  EXPECT_LT((s.accel_bias_mps2 - expected.accel_bias_mps2).norm(), 1e-7);
  EXPECT_LT((s.g_odom_mps2 - expected.g_odom_mps2).norm(), 1e-6);
  EXPECT_EQ(s.P, StateCov(s.P.transpose()));
}

TEST(UpdateLinear, equals_the_information_form_update_in_one_two_and_three_dimensions) {
  Rng rng(1, "linear");
  for (int k = 0; k < 5; ++k) {
    expect_textbook_update<1>(rng);
    expect_textbook_update<2>(rng);
    expect_textbook_update<3>(rng);
  }
}

// Test T4 of the design: prior sd 0.1 m, r = 0.06 m, s = 2 cm.
TEST(UpdateLinear, gain_matches_hand_computed_values) {
  FilterState s;
  s.P(kPos, kPos) = 0.01;
  Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
  H(0, kPos) = 1.0;
  update_linear<1>(s, H, Eigen::Matrix<double, 1, 1>{0.06}, Eigen::Matrix<double, 1, 1>{4e-4});
  EXPECT_NEAR(s.T_odom_body.p.x(), 0.05769, 1e-5);
  EXPECT_NEAR(std::sqrt(s.P(kPos, kPos)), 0.01961, 1e-5);
}

/// Floor and two walls along x, rotated by yaw, without end walls if `open`.
struct Place {
  PlaneMap map{PlaneMapSettings{}};
  RobustSettings settings;
  std::vector<Vec3> surface;  ///< points on the walls, in odom

  explicit Place(bool open, double yaw_rad = 0.0) {
    const Mat3 R = so3_exp(Vec3(0.0, 0.0, yaw_rad));
    const Vec3 x = R.col(0);
    const Vec3 y = R.col(1);
    const Vec3 z = Vec3::UnitZ();
    add(R * Vec3(-2.0, -1.2, -1.2), z, x, y, 6, 4);
    add(R * Vec3(-2.0, 2.0, -0.4), y, x, z, 6, 3);
    add(R * Vec3(-2.0, -2.0, -0.4), y, x, z, 6, 3);
    if (!open) add(R * Vec3(3.6, -1.2, -0.4), x, y, z, 4, 3);
  }

  void add(const Vec3& first, const Vec3& n, const Vec3& along, const Vec3& up, int a, int b) {
    insert_wall(map, first, n, along, up, a, b);
    const double voxel_m = map.settings().voxel_m;
    for (int i = 0; i < 3 * a; ++i) {
      for (int j = 0; j < 3 * b; ++j) {
        surface.emplace_back(first + voxel_m * ((i - 1) / 3.0 * along + (j - 1) / 3.0 * up));
      }
    }
  }

  [[nodiscard]] BodyPoints seen_from(const SE3& T) const {
    BodyPoints out;
    out.resize(surface.size());
    for (std::size_t i = 0; i < surface.size(); ++i) {
      const Vec3 p = T.inverse() * surface[i];
      out.x_m[i] = static_cast<float>(p.x());
      out.y_m[i] = static_cast<float>(p.y());
      out.z_m[i] = static_cast<float>(p.z());
    }
    return out;
  }

  UpdateResult update(FilterState& state, const SE3& truth) {
    Matcher matcher(settings.match);
    matcher.set_points(seen_from(truth), Vec3::Zero());
    return update_with_scan(state, matcher, map, state.T_odom_body, settings,
                            degeneracy::Axes::Identity(), {}, true);
  }
};

FilterState guess_near(const SE3& truth, const Vec3& turn, const Vec3& shift) {
  FilterState s;
  s.T_odom_body = {truth.R * so3_exp(turn), truth.p + shift};
  s.P.setIdentity();
  s.P *= 1e-4;
  s.P.diagonal().segment<3>(kTheta).setConstant(0.03 * 0.03);
  s.P.diagonal().segment<3>(kPos).setConstant(0.1 * 0.1);
  return s;
}

const SE3 kTruth{so3_exp(Vec3(0.02, -0.03, 0.5)), Vec3(0.1, 0.05, 0.03)};

TEST(UpdateWithScan, finds_the_pose_within_2_mm_when_all_directions_are_observable) {
  Place place(false);
  FilterState s = guess_near(kTruth, Vec3(0.01, -0.02, 0.03), Vec3(0.05, -0.06, 0.04));
  const UpdateResult done = place.update(s, kTruth);
  EXPECT_TRUE(done.converged);
  EXPECT_GT(done.matches, 300);
  EXPECT_LT((s.T_odom_body.p - kTruth.p).norm(), 2e-3);
  EXPECT_LT(geometry::so3_log(kTruth.R.transpose() * s.T_odom_body.R).norm(), 1e-3);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(done.directions[k].category, degeneracy::Category::kFull) << k;
  }
}

/// A plane through few points in the middle of a cell, as in a young map.
Patch small_patch(const Vec3& center, const Vec3& n) {
  Patch patch;
  patch.center = center;
  patch.n = n;
  patch.spacing_m = 0.04;  // reaches 0.28 m
  return patch;
}

TEST(UpdateWithScan, ignores_planes_whose_points_do_not_surround_the_match) {
  Place place(false);
  const std::size_t walls = place.surface.size();
  // A ceiling, and a plane in one of its cells that is 10 degrees off.
  const Vec3 center(2.0, 0.4, 2.0);
  const double tilt = 0.17;
  insert_patch(place.map, small_patch(center, Vec3(std::sin(tilt), 0.0, std::cos(tilt))));
  for (int k = 0; k < 60; ++k) place.surface.emplace_back(center + Vec3(0.33, 0.005 * k - 0.15, 0));
  FilterState s = guess_near(kTruth, Vec3(0.01, -0.02, 0.03), Vec3(0.05, -0.06, 0.04));
  const UpdateResult done = place.update(s, kTruth);
  EXPECT_EQ(done.matches, static_cast<int>(walls));
  EXPECT_LT((s.T_odom_body.p - kTruth.p).norm(), 2e-3);
  EXPECT_LT(geometry::so3_log(kTruth.R.transpose() * s.T_odom_body.R).norm(), 1e-3);
}

TEST(UpdateWithScan, uses_planes_beyond_their_points_when_too_few_match) {
  Place place(false);
  place.map = PlaneMap(PlaneMapSettings{});
  place.surface.clear();
  for (int k = -2; k < 3; ++k) {
    for (const Vec3& n : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
      const Vec3 along(n.y(), n.z(), n.x());
      const Vec3 up = n.cross(along);
      const Vec3 center = 0.8 * (4.5 * n + (k + 0.5) * (along + up));
      insert_patch(place.map, small_patch(center, n));
      for (int i = 0; i < 30; ++i) {
        place.surface.emplace_back(center + 0.33 * along + (0.01 * i - 0.15) * up);
      }
    }
  }
  FilterState s = guess_near(kTruth, Vec3(0.005, -0.005, 0.005), Vec3(0.02, -0.02, 0.02));
  const UpdateResult done = place.update(s, kTruth);
  EXPECT_EQ(done.matches, static_cast<int>(place.surface.size()));
  EXPECT_LT((s.T_odom_body.p - kTruth.p).norm(), 2e-3);
}

TEST(UpdateWithScan, leaves_the_degenerate_direction_as_predicted) {
  Place place(true);
  const Vec3 shift(0.05, -0.06, 0.04);
  FilterState s = guess_near(kTruth, Vec3::Zero(), shift);
  const FilterState before = s;
  const UpdateResult done = place.update(s, kTruth);
  EXPECT_GT(done.matches, 200);
  EXPECT_EQ(done.directions[0].category, degeneracy::Category::kNone);
  EXPECT_LT(std::abs(done.information(3, 3)), 1e-9);
  // Along the corridor there is no information: pose and variance stay those of the prior.
  EXPECT_NEAR(s.T_odom_body.p.x(), before.T_odom_body.p.x(), 1e-9);
  EXPECT_NEAR(s.P(kPos, kPos), 0.01, 1e-10);
  // Laterally and vertically the pose is corrected.
  EXPECT_NEAR(s.T_odom_body.p.y(), kTruth.p.y(), 2e-3);
  EXPECT_NEAR(s.T_odom_body.p.z(), kTruth.p.z(), 2e-3);
  EXPECT_LT(s.P(kPos + 1, kPos + 1), 1e-4);
}

// Regression: 150 s into a tunnel the filter's sigmas along it were 8 m and 0.3 m/s. The observed
// axis jittered by milliradians, and 8 m times 5 mrad are 4 cm laterally: walls known to
// millimetres then appeared as information on position and speed along the tunnel.
TEST(UpdateWithScan, jitter_of_the_degenerate_axis_adds_no_information_along_it) {
  Place left(true, 5e-3);
  Place right(true, -5e-3);
  FilterState s = guess_near(kTruth, Vec3::Zero(), Vec3(0.05, 0.01, 0.0));
  s.P(kPos, kPos) = 64.0;
  s.P(kVel, kVel) = 0.09;
  s.P(kPos, kVel) = s.P(kVel, kPos) = 0.9 * 8.0 * 0.3;
  const FilterState before = s;
  for (int k = 0; k < 4; ++k) {
    // As after a scan of driving: the lateral sigma is 1 cm again.
    s.P.diagonal().segment<2>(kPos + 1).array() += 1e-4;
    const UpdateResult done = (k % 2 == 0 ? left : right).update(s, kTruth);
    EXPECT_GT(done.matches, 200);
    EXPECT_EQ(done.directions[0].category, degeneracy::Category::kNone);
  }
  EXPECT_NEAR(s.T_odom_body.p.x(), before.T_odom_body.p.x(), 1e-3);
  EXPECT_NEAR(s.v.x(), before.v.x(), 1e-4);
  EXPECT_NEAR(std::sqrt(s.P(kPos, kPos)), 8.0, 0.01);
  EXPECT_NEAR(std::sqrt(s.P(kVel, kVel)), 0.3, 0.001);
  EXPECT_LT(std::sqrt(s.P(kPos + 1, kPos + 1)), 0.06);
}

TEST(UpdateWithScan, corrects_velocity_correlated_with_the_pose) {
  Place place(false);
  FilterState s = guess_near(kTruth, Vec3::Zero(), Vec3(0.05, 0.0, 0.0));
  s.P(kVel, kVel) = 1.0;
  s.P(kVel, kPos) = s.P(kPos, kVel) = 0.09;  // the position error came from the speed
  static_cast<void>(place.update(s, kTruth));
  EXPECT_NEAR(s.v.x(), -0.05 * 0.09 / 0.01, 0.05);
  EXPECT_NEAR(s.P(kVel, kVel), 1.0 - 0.09 * 0.09 / 0.01, 0.05);
}

TEST(UpdateWithScan, covariance_stays_symmetric_positive_and_shrinks) {
  Rng rng(2, "cov");
  Place place(false);
  for (int k = 0; k < 3; ++k) {
    FilterState s = guess_near(kTruth, Vec3(0.02, 0.0, -0.02), Vec3(0.03, 0.03, 0.0));
    s.P += random_covariance(rng);
    const StateCov before = s.P;
    static_cast<void>(place.update(s, kTruth));
    EXPECT_EQ(s.P, StateCov(s.P.transpose()));
    const auto smallest = [](const StateCov& M) {
      return Eigen::SelfAdjointEigenSolver<StateCov>(M).eigenvalues()[0];
    };
    EXPECT_GT(smallest(s.P), -1e-9);
    EXPECT_LT(s.P.trace(), before.trace());
  }
}

TEST(UpdateWithScan, keeps_the_state_with_too_few_matches) {
  Place place(false);
  FilterState s = guess_near(kTruth, Vec3::Zero(), Vec3(0.05, 0.0, 0.0));
  const FilterState before = s;
  SE3 elsewhere = kTruth;
  elsewhere.p += Vec3(500.0, 0.0, 0.0);  // the scan fits nowhere
  const UpdateResult done = place.update(s, elsewhere);
  EXPECT_LT(done.matches, place.settings.update.matches_min);
  EXPECT_FALSE(done.converged);
  EXPECT_EQ(s.T_odom_body.p, before.T_odom_body.p);
  EXPECT_EQ(s.T_odom_body.R, before.T_odom_body.R);
  EXPECT_EQ(s.P, before.P);
}

TEST(UpdateWithScan, keeps_a_prior_with_very_small_covariance) {
  Place place(false);
  FilterState s = guess_near(kTruth, Vec3::Zero(), Vec3(0.03, 0.0, 0.0));
  s.P *= 1e-12;
  static_cast<void>(place.update(s, kTruth));
  EXPECT_NEAR(s.T_odom_body.p.x(), kTruth.p.x() + 0.03, 1e-6);
}

}  // namespace
}  // namespace rali::odometry
