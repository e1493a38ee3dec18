#include "rali/odometry/robust/matcher.hpp"

#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/robust.hpp"
#include "rali/odometry/robust/patches_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;
using geometry::Vec6;

BodyPoints points_of(const std::vector<Vec3>& list) {
  BodyPoints out;
  out.resize(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    out.x_m[i] = static_cast<float>(list[i].x());
    out.y_m[i] = static_cast<float>(list[i].y());
    out.z_m[i] = static_cast<float>(list[i].z());
  }
  return out;
}

/// One plane in one huge cell with `points` points, fitted when all are inserted.
PlaneMapSettings one_cell(double voxel_m, int points) {
  PlaneMapSettings settings;
  settings.voxel_m = voxel_m;
  settings.freeze_points = 100000;
  settings.plane.points_min = points;
  settings.plane.sigma_floor_m = 0.02;  // exact points: the floor acts as their noise
  settings.plane.sigma_between_m = 0.0;
  settings.plane.width_min_ratio = 0.0;  // small patches in a huge cell
  return settings;
}

// Test T2 of the design, shifted by 50 m so that all points lie in one cell.
TEST(Matcher, residual_and_jacobian_match_hand_computed_values) {
  PlaneMap map(one_cell(100.0, 100));
  Patch patch;
  patch.center = Vec3(51.0, 51.0, 51.0);
  patch.n = Vec3(0.6, 0.8, 0.0);
  insert_patch(map, patch);
  ASSERT_EQ(map.plane_count(), 1U);
  MatchSettings settings;
  settings.gate_max_m = 10.0;
  settings.range_sigma_m = 0.0;
  Matcher matcher(settings);
  matcher.set_points(points_of({Vec3(4.0, 2.0, -0.5)}), Vec3::Zero());
  const SE3 T{so3_exp(Vec3(0.1, -0.2, 0.7)), Vec3(53.0, 49.0, 50.4)};
  matcher.match(map, T, 100.0 * Mat6::Identity(), Reach::kCell);  // it lies beyond the patch
  const LidarSystem system = matcher.accumulate(map, T);
  ASSERT_EQ(system.matches, 1);
  // One point: I = W H^T H and b = W H^T r, with dr/dp = n of length one.
  const double W = system.I.bottomRightCorner<3, 3>().trace();
  const double r = system.b.tail<3>().dot(patch.n) / W;
  EXPECT_NEAR(r, 3.953059, 4e-6);
  const Vec3 d_theta = system.b.head<3>() / (W * r);
  EXPECT_LT((d_theta - Vec3(-0.321917, 0.388069, -1.023060)).norm(), 2e-6);
  EXPECT_LT((system.b.tail<3>() / (W * r) - patch.n).norm(), 1e-6);
  Vec6 H;
  H << d_theta, patch.n;
  EXPECT_LT((system.I - W * H * H.transpose()).norm(), 1e-5 * W);
}

/// Test T4: the plane has N = 100, s = 2 cm, tilt sd 0.005 about both axes; the body lies in it.
struct CorrelatedPlane {
  PlaneMap map{settings()};
  SE3 T{geometry::Mat3::Identity(), Vec3(5.0, 5.0, 5.0)};
  Matcher matcher{noise()};

  CorrelatedPlane() {
    Patch patch;
    patch.center = T.p;
    patch.spacing_m = std::sqrt(0.16 / 8.25);  // variance of 10 equidistant points: 8.25 spacing^2
    insert_patch(map, patch);
  }

  static PlaneMapSettings settings() { return one_cell(10.0, 100); }

  static MatchSettings noise() {
    MatchSettings out;
    out.beam_sigma_rad = 0.0;
    out.rough_sigma_m = 0.02;  // points are seen edge-on: range noise has no effect
    return out;
  }

  LidarSystem system(int times) {
    std::vector<Vec3> points;
    for (int k = 0; k < times; ++k) {
      for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) points.emplace_back(x, y, 0.0);
      }
    }
    matcher.set_points(points_of(points), Vec3::Zero());
    matcher.match(map, T, Mat6::Zero(), Reach::kCell);  // the corners lie beyond the patch
    return matcher.accumulate(map, T);
  }
};

TEST(Matcher, points_on_one_plane_have_the_common_error_of_that_plane) {
  CorrelatedPlane setup;
  ASSERT_EQ(setup.map.plane_count(), 1U);
  EXPECT_NEAR(setup.map.plane(0).var_offset, 1.04e-4, 1e-10);
  EXPECT_NEAR(std::sqrt(setup.map.plane(0).var_tilt1), 0.005, 1e-8);
  EXPECT_NEAR(std::sqrt(setup.map.plane(0).var_tilt2), 0.005, 1e-8);
  const LidarSystem s = setup.system(1);
  ASSERT_EQ(s.matches, 4);
  Mat6 expected = Mat6::Zero();
  expected.diagonal() << 8000.0, 8000.0, 0.0, 0.0, 0.0, 4901.96;  // naive: 10000 each
  EXPECT_LT((s.I - expected).norm(), 0.05);
  EXPECT_LT(s.b.norm(), 1e-6);
  EXPECT_NEAR(1e3 / std::sqrt(s.I(5, 5)), 14.28, 0.005);
  EXPECT_NEAR(1e3 / std::sqrt(s.I(1, 1)), 11.18, 0.005);
}

TEST(Matcher, information_of_many_points_is_limited_by_the_plane_covariance) {
  CorrelatedPlane setup;
  const LidarSystem s = setup.system(1000);
  EXPECT_NEAR(1e3 / std::sqrt(s.I(5, 5)), 10.20, 0.005);
  EXPECT_NEAR(1e3 / std::sqrt(s.I(1, 1)), 5.01, 0.005);
}

/// Reference for the matcher: pose and the planes' three errors are all unknowns, Jacobians are
/// numerical, planes are marginalised at the end.
struct BruteForce {
  const PlaneMap& map;
  MatchSettings settings;
  std::vector<Vec3> points;
  std::vector<int> planes;  ///< of each point

  [[nodiscard]] double residual(std::size_t i, const SE3& T, const Vec3& error) const {
    const Plane& k = map.plane(planes[i]);
    const Vec3 n = k.n + error[0] * k.e1 + error[1] * k.e2;
    return n.dot(T * points[i] - k.q) - error[2];
  }

  [[nodiscard]] double weight(std::size_t i, const SE3& T) const {
    const Plane& k = map.plane(planes[i]);
    const Vec3 d = T * points[i] - k.q;
    const double c = k.n.dot(T.R * points[i].normalized());
    const double beam = points[i].norm() * settings.beam_sigma_rad;
    const double range = settings.range_sigma_m;
    const double rough = settings.rough_sigma_m;
    const double s2 =
        std::max(c * c * range * range + (1.0 - c * c) * beam * beam + rough * rough, k.var_normal);
    const double plane_var = k.var_offset + std::pow(k.e1.dot(d), 2) * k.var_tilt1 +
                             std::pow(k.e2.dot(d), 2) * k.var_tilt2;
    return geometry::cauchy_weight(k.n.dot(d) / std::sqrt(s2 + plane_var), settings.cauchy_scale) /
           s2;
  }

  void solve(const SE3& T, Mat6& I, Vec6& b) const {
    const auto dim = static_cast<Eigen::Index>(6 + 3 * map.plane_count());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(dim, dim);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(dim);
    for (std::size_t k = 0; k < map.plane_count(); ++k) {
      const Plane& plane = map.plane(static_cast<int>(k));
      A.diagonal().segment<3>(static_cast<Eigen::Index>(6 + 3 * k)) =
          Vec3(1.0 / plane.var_tilt1, 1.0 / plane.var_tilt2, 1.0 / plane.var_offset);
    }
    constexpr double kStep = 1e-6;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::VectorXd J = Eigen::VectorXd::Zero(dim);
      for (int c = 0; c < 6; ++c) {
        const Vec6 d = kStep * Vec6::Unit(c);
        J[c] = (residual(i, geometry::boxplus(T, d), Vec3::Zero()) -
                residual(i, geometry::boxplus(T, -d), Vec3::Zero())) /
               (2.0 * kStep);
      }
      for (int c = 0; c < 3; ++c) {
        const Vec3 d = kStep * Vec3::Unit(c);
        J[6 + 3 * planes[i] + c] = (residual(i, T, d) - residual(i, T, -d)) / (2.0 * kStep);
      }
      const double w = weight(i, T);
      A += w * J * J.transpose();
      g += w * residual(i, T, Vec3::Zero()) * J;
    }
    const Eigen::Index rest = dim - 6;
    const Eigen::MatrixXd gain =
        A.topRightCorner(6, rest) * A.bottomRightCorner(rest, rest).inverse();
    I = A.topLeftCorner<6, 6>() - gain * A.bottomLeftCorner(rest, 6);
    b = g.head<6>() - gain * g.tail(rest);
  }
};

TEST(Matcher, system_equals_that_of_marginalising_explicit_plane_errors) {
  Rng rng(1, "brute");
  PlaneMap map{PlaneMapSettings{}};
  const std::vector<Patch> patches{{Vec3(2.0, 0.4, 0.4), Vec3(1.0, 0.1, 0.2).normalized()},
                                   {Vec3(0.4, 2.0, 0.4), Vec3(-0.1, 1.0, 0.0).normalized()},
                                   {Vec3(0.4, 0.4, -1.2), Vec3(0.0, 0.1, 1.0).normalized()},
                                   {Vec3(-2.0, -1.2, 0.4), Vec3(1.0, 1.0, 0.0).normalized()}};
  for (const Patch& patch : patches) insert_patch(map, patch);
  ASSERT_EQ(map.plane_count(), patches.size());
  const SE3 T{so3_exp(Vec3(0.3, -0.8, 1.9)), Vec3(0.1, 0.2, -0.1)};
  std::vector<Vec3> wanted;
  for (const Patch& patch : patches) {
    for (int k = 0; k < 7; ++k) {
      const Vec3 jitter(rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1));
      wanted.push_back(T.inverse() * (patch.center + jitter));
    }
  }
  const BodyPoints cloud = points_of(wanted);
  MatchSettings settings;
  settings.gate_min_m = 1.0;     // all match, also distant ones: robust weights differ from 1
  settings.range_sigma_m = 0.0;  // see the test of oblique walls
  settings.rough_sigma_m = 0.02;
  BruteForce brute{map, settings, {}, {}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    brute.points.emplace_back(cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]);
    brute.planes.push_back(map.find(T * brute.points.back()));
    ASSERT_GE(brute.planes.back(), 0);
  }
  Matcher matcher(settings);
  matcher.set_points(cloud, Vec3::Zero());
  matcher.match(map, T, Mat6::Zero(), Reach::kPoints);
  const LidarSystem system = matcher.accumulate(map, T);
  ASSERT_EQ(system.matches, static_cast<int>(wanted.size()));
  Mat6 I;
  Vec6 b;
  brute.solve(T, I, b);
  EXPECT_LT((system.I - I).norm(), 1e-5 * I.norm());
  EXPECT_LT((system.b - b).norm(), 1e-5 * b.norm());
  EXPECT_EQ(matcher.evidence().size(), patches.size());
}

TEST(Matcher, rejects_points_outside_the_gate_or_without_a_plane) {
  CorrelatedPlane setup;
  setup.matcher.set_points(
      points_of({Vec3(0.5, 0.0, 0.04), Vec3(0.5, 0.0, 0.2), Vec3(50.0, 0.0, 0.0)}), Vec3::Zero());
  setup.matcher.match(setup.map, setup.T, Mat6::Zero(), Reach::kPoints);
  EXPECT_EQ(setup.matcher.accumulate(setup.map, setup.T).matches, 1);
  // A pose sigma of 10 cm opens the gate for the second point.
  setup.matcher.match(setup.map, setup.T, 0.01 * Mat6::Identity(), Reach::kPoints);
  EXPECT_EQ(setup.matcher.accumulate(setup.map, setup.T).matches, 2);
}

TEST(Matcher, matches_beyond_a_plane_patch_only_with_cell_reach) {
  CorrelatedPlane setup;  // 0.4 m sd along both axes: 2 sd and 5 cm
  setup.matcher.set_points(
      points_of({Vec3(0.84, 0.0, 0.0), Vec3(0.86, 0.0, 0.0), Vec3(0.6, -0.86, 0.0)}), Vec3::Zero());
  setup.matcher.match(setup.map, setup.T, Mat6::Zero(), Reach::kPoints);
  EXPECT_EQ(setup.matcher.accumulate(setup.map, setup.T).matches, 1);
  setup.matcher.match(setup.map, setup.T, Mat6::Zero(), Reach::kCell);
  EXPECT_EQ(setup.matcher.accumulate(setup.map, setup.T).matches, 3);
}

TEST(Matcher, agreement_counts_points_within_the_extent_of_a_plane_only) {
  CorrelatedPlane setup;  // up to 0.85 m along both axes
  const auto agreement = [&setup](const std::vector<Vec3>& points) {
    setup.matcher.set_points(points_of(points), Vec3::Zero());
    return setup.matcher.overlap(setup.map, setup.T).agreement();
  };
  const Vec3 on(0.5, 0.2, 0.01), off(0.3, 0.1, 0.3), beyond(1.5, 0.0, 0.3);
  EXPECT_DOUBLE_EQ(agreement({on, on, off, beyond}), 2.0 / 3.0);
  EXPECT_EQ(agreement({beyond, Vec3(500.0, 0.0, 0.0)}), 0.0) << "unseen";
  EXPECT_EQ(agreement({}), 0.0);
}

TEST(Matcher, reduces_the_weight_of_outliers) {
  CorrelatedPlane setup;
  const auto pull = [&setup](double height_m) {
    setup.matcher.set_points(points_of({Vec3(0.5, 0.5, height_m)}), Vec3::Zero());
    setup.matcher.match(setup.map, setup.T, Mat6::Identity(), Reach::kPoints);
    return setup.matcher.accumulate(setup.map, setup.T).b[5];
  };
  EXPECT_GT(pull(0.04), pull(0.02));
  EXPECT_LT(pull(0.8), pull(0.06));  // far beyond the knee it pulls less, not more
}

/// Walls across the path, and the points of a scan from the origin on the first of them.
struct AcrossThePath {
  PlaneMap map{PlaneMapSettings{}};
  std::vector<Vec3> points;

  AcrossThePath(double epoch, const std::vector<double>& walls_m) {
    Rng rng(3);
    for (const double x_m : walls_m) {
      for (int k = 0; k < 400; ++k) {
        const Vec3 p(x_m + 0.005 * rng.normal(), rng.uniform(-0.75, 0.75), rng.uniform(0.05, 0.75));
        map.insert(p, p.normalized().cast<float>(), epoch);
      }
    }
    for (int k = 0; k < 40; ++k) {
      points.emplace_back(walls_m.front(), rng.uniform(-0.7, 0.7), rng.uniform(0.1, 0.7));
    }
  }

  [[nodiscard]] Matcher matched() const {
    Matcher matcher{MatchSettings{}};
    matcher.set_points(points_of(points), Vec3::Zero());
    matcher.match(map, SE3{}, 1e-4 * Mat6::Identity(), Reach::kPoints);
    return matcher;
  }

  [[nodiscard]] Hold hold(double newest_epoch) const {
    return matched().hold_along(map, SE3{}, Vec3::UnitX(), 0.4, newest_epoch);
  }
};

TEST(Matcher, a_single_wall_across_constrains_motion_at_one_position_only) {
  const AcrossThePath wall(4.0, {10.75});
  const Hold hold = wall.hold(5.0);
  EXPECT_EQ(wall.matched().points_facing(wall.map, Vec3::UnitX()), 40U);
  EXPECT_GT(hold.here, 1e4);
  EXPECT_EQ(hold.elsewhere, 0.0);
}

TEST(Matcher, a_repeated_wall_also_constrains_motion_at_a_shifted_position) {
  const Hold hold = AcrossThePath(4.0, {10.75, 10.35}).hold(5.0);
  EXPECT_GT(hold.here, 1e4);
  EXPECT_GT(hold.elsewhere, 0.9 * hold.here);
}

TEST(Matcher, planes_newer_than_the_established_epoch_do_not_constrain_motion) {
  EXPECT_EQ(AcrossThePath(6.0, {10.75}).hold(5.0).here, 0.0);
  EXPECT_GT(AcrossThePath(0.0, {10.75}).hold(0.0).here, 1e4) << "what was there before does";
}

TEST(Matcher, a_wall_does_not_constrain_motion_along_itself) {
  const AcrossThePath wall(4.0, {10.75});
  EXPECT_EQ(wall.matched().points_facing(wall.map, Vec3::UnitY()), 0U);
  EXPECT_EQ(wall.matched().hold_along(wall.map, SE3{}, Vec3::UnitY(), 0.4, 5.0).here, 0.0);
}

/// Points measured within a patch of a long wall, 3 m to the left, about 4 m ahead: noise along the
/// rays moves points in and out.
std::vector<Vec3> cut_from_a_wall(double range_sigma_m, Rng& rng) {
  std::vector<Vec3> out;
  while (out.size() < 400) {
    Vec3 p(rng.uniform(3.0, 5.0), 3.0, rng.uniform(-0.4, 0.4));
    p += range_sigma_m * rng.normal() * p.normalized();
    if (std::abs(p.x() - 4.0) < 0.4) out.push_back(p);
  }
  return out;
}

// Noise along a ray moves a point along and across the wall at once, but the position of a point is
// independent of its noise. Subtracting it nevertheless would rotate the wall by 7 mrad, always to
// the same side: s^2 d1 dn / l, with noise s along the ray d and spread l of the wall's piece.
TEST(Matcher, range_noise_does_not_rotate_a_wall_measured_obliquely) {
  PlaneMap map(one_cell(10.0, 100));
  Patch patch;
  const SE3 T{geometry::Mat3::Identity(), Vec3(0.0, 0.0, 5.0)};
  patch.center = T * Vec3(4.0, 3.0, 0.0);
  patch.n = Vec3(0.0, -1.0, 0.0);
  patch.spacing_m = 0.08;
  insert_patch(map, patch);
  ASSERT_EQ(map.plane_count(), 1U);
  MatchSettings settings;
  settings.range_sigma_m = 0.03;
  settings.beam_sigma_rad = 0.0;
  settings.cauchy_scale = 100.0;
  settings.gate_min_m = 1.0;
  Rng rng(1, "oblique");
  double turn_rad = 0.0;
  constexpr int kScans = 100;
  for (int k = 0; k < kScans; ++k) {
    Matcher matcher(settings);
    matcher.set_points(points_of(cut_from_a_wall(settings.range_sigma_m, rng)), Vec3::Zero());
    matcher.match(map, T, 1e-4 * Mat6::Identity(), Reach::kPoints);
    const LidarSystem system = matcher.accumulate(map, T);
    // Rotation about the patch itself: heading, and the lateral shift that keeps its centre.
    Vec6 about_patch = Vec6::Zero();
    about_patch[2] = 1.0;
    about_patch[4] = -4.0;
    turn_rad -= about_patch.dot(system.b) / about_patch.dot(system.I * about_patch) / kScans;
  }
  EXPECT_LT(std::abs(turn_rad), 0.001);
}

TEST(Matcher, works_without_points_and_without_map) {
  CorrelatedPlane setup;
  setup.matcher.set_points(BodyPoints{}, Vec3::Zero());
  setup.matcher.match(setup.map, setup.T, Mat6::Zero(), Reach::kNear);
  EXPECT_EQ(setup.matcher.accumulate(setup.map, setup.T).matches, 0);
  const PlaneMap empty{PlaneMapSettings{}};
  setup.matcher.set_points(points_of({Vec3(1.0, 0.0, 0.0)}), Vec3(1.0, 0.0, 0.0));
  setup.matcher.match(empty, setup.T, Mat6::Zero(), Reach::kNear);
  const LidarSystem system = setup.matcher.accumulate(empty, setup.T);
  EXPECT_EQ(system.matches, 0);
  EXPECT_EQ(system.I, Mat6(Mat6::Zero()));
}

}  // namespace
}  // namespace rali::odometry
