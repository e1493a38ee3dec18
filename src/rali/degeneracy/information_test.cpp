#include "rali/degeneracy/information.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/degeneracy/plane_for_test.hpp"

namespace rali::degeneracy {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::so3_exp;
using geometry::Vec3;
using geometry::Vec6;

const Vec3 kGravity(0.0, 0.0, -9.81);

Mat6 information_of(const std::vector<PlaneEvidence>& planes) {
  Mat6 I = Mat6::Zero();
  I.topLeftCorner<3, 3>() = 1e6 * Mat3::Identity();  // rotations known and uncoupled
  for (const PlaneEvidence& p : planes) {
    I.block<3, 3>(3, 3) += p.weight * p.n_odom * p.n_odom.transpose();
  }
  return I;
}

std::vector<PlaneEvidence> corridor(bool end_wall) {
  std::vector<PlaneEvidence> planes{plane(Vec3::UnitY(), 100), plane(Vec3::UnitZ(), 50)};
  if (end_wall) planes.push_back(plane(Vec3::UnitX(), 4));
  return planes;
}

AwareSettings kappa4() {
  AwareSettings settings;
  settings.kappa = 4.0;
  return settings;
}

// Test T11 of the design.
TEST(DirectionInformation, matches_hand_computed_values_for_a_corridor_with_an_end_wall) {
  const auto planes = corridor(true);
  EXPECT_NEAR(planes[0].weight, 9434.0, 0.1);
  EXPECT_NEAR(planes[1].weight, 9090.9, 0.1);
  EXPECT_NEAR(planes[2].weight, 4950.5, 0.1);
  const auto out = direction_information(information_of(planes), planes, Mat3::Identity(),
                                         Axes::Identity(), kappa4());
  const double noise[] = {1.852, 1.404, 1.438};
  const double sigma_m[] = {0.0142, 0.0103, 0.0105};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR((out[k].raw - out[k].information) / 4.0, noise[k], 1e-3) << k;
    EXPECT_NEAR(out[k].sigma, sigma_m[k], 5e-5) << k;
    EXPECT_EQ(out[k].category, Category::kFull) << k;
  }
}

TEST(DirectionInformation, is_zero_along_a_corridor_without_an_end_wall) {
  const auto planes = corridor(false);
  const auto out = direction_information(information_of(planes), planes, Mat3::Identity(),
                                         Axes::Identity(), kappa4());
  EXPECT_EQ(out[0].raw, 0.0);
  EXPECT_EQ(out[0].information, 0.0);
  EXPECT_TRUE(std::isinf(out[0].sigma));
  EXPECT_EQ(out[0].category, Category::kNone);
  EXPECT_NEAR(out[1].sigma, 0.0103, 5e-5);
  EXPECT_NEAR(out[2].sigma, 0.0105, 5e-5);
}

TEST(DirectionInformation, excludes_information_that_noise_of_the_normals_alone_explains) {
  // Ten walls along x whose normals are off by their own sigma: their information along x is what
  // chance alone gives.
  std::vector<PlaneEvidence> planes;
  for (int k = 0; k < 10; ++k) {
    const double tilt = (k % 2 == 0 ? 1.0 : -1.0) * 0.01;
    planes.push_back(plane(Vec3(tilt, std::sqrt(1.0 - tilt * tilt), 0.0), 100));
  }
  planes.push_back(plane(Vec3::UnitZ(), 100));
  const auto out = direction_information(information_of(planes), planes, Mat3::Identity(),
                                         Axes::Identity(), kappa4());
  EXPECT_NEAR(out[0].raw, 9.4, 0.1);
  EXPECT_EQ(out[0].information, 0.0);
  EXPECT_EQ(out[0].category, Category::kNone);
}

TEST(DirectionInformation,
     without_imu_subtracts_chance_information_summed_over_planes_plus_4_sigma) {
  // 100 planes along the corridor give w 1e-4 = 0.943 each along x by chance: 94.3 in all. Four
  // times the root of the sum of their squares above it is 132. Five times the mean is 472.
  std::vector<PlaneEvidence> planes(100, plane(Vec3::UnitY(), 100));
  for (const int end_planes : {0, 4}) {
    for (int k = 0; k < end_planes; ++k) {
      PlaneEvidence wall = plane(Vec3::UnitX(), 4);
      wall.weight = 50.0;
      wall.lever_odom_m = Vec3(20.0, 3.0 * k, 0.0);
      planes.push_back(wall);
    }
    AwareSettings settings;
    settings.kappa_supported = settings.kappa = 5.0;
    settings.trusts_support = false;
    settings.lidar_alone = true;
    const auto alone = direction_information(information_of(planes), planes, Mat3::Identity(),
                                             Axes::Identity(), settings);
    settings.lidar_alone = false;
    const auto inertial = direction_information(information_of(planes), planes, Mat3::Identity(),
                                                Axes::Identity(), settings);
    EXPECT_EQ(inertial[0].information, 0.0) << "0 or 200, and 472 may be chance";
    EXPECT_NEAR(alone[0].information, end_planes > 0 ? 200.0 - 94.3396 - 4.0 * 9.43396 : 0.0, 1e-3);
  }
}

// 700 wall planes give 660 1/m^2 by chance, an end wall 75 m ahead four times 200.
TEST(DirectionInformation, knows_the_position_between_walls_across_a_long_corridor) {
  std::vector<PlaneEvidence> planes(700, plane(Vec3::UnitY(), 100));
  for (int k = 0; k < 4; ++k) {
    PlaneEvidence wall = plane(Vec3::UnitX(), 1);
    wall.weight = 200.0;
    wall.lever_odom_m = Vec3(75.0, 0.8 * k, 1.0);
    wall.residual_m = 0.03;
    planes.push_back(wall);
  }
  const auto known = [&planes](bool trusts_support) {
    AwareSettings settings;
    settings.trusts_support = trusts_support;
    return direction_information(information_of(planes), planes, Mat3::Identity(), Axes::Identity(),
                                 settings)[0];
  };
  EXPECT_NEAR(known(true).information, 800.0, 1.0);
  EXPECT_NEAR(known(true).wall_residual_m.value_or(0.0), 0.03, 1e-9);
  EXPECT_EQ(known(false).information, 0.0) << "at standstill they may be passers-by";
  Mat6 freed = information_of(planes);
  freed.row(3).setZero();
  freed.col(3).setZero();
  const auto free = direction_information(freed, planes, Mat3::Identity(), Axes::Identity(), {});
  EXPECT_EQ(free[0].information, 0.0) << "whoever uses the planes has left this direction open";
}

TEST(DirectionInformation, without_imu_is_zero_along_a_direction_supported_by_one_plane) {
  const auto planes = corridor(true);
  AwareSettings settings;
  settings.lidar_alone = true;
  const auto out = direction_information(information_of(planes), planes, Mat3::Identity(),
                                         Axes::Identity(), settings);
  EXPECT_EQ(out[0].information, 0.0);
  EXPECT_EQ(out[0].category, Category::kNone);
}

TEST(DirectionInformation, keeps_weak_structure_supported_by_several_planes_in_separate_clusters) {
  // Long walls with uncertain normals, and four sides of niches that give 75 1/m^2 each.
  std::vector<PlaneEvidence> planes;
  for (int k = 0; k < 80; ++k) planes.push_back(plane(Vec3::UnitY(), 100));
  const double expected = 80.0 * 9434.0 * 1e-4;  // B_x = 75.5 1/m^2
  const auto reported = [&](double apart_m) {
    auto all = planes;
    for (int k = 0; k < 4; ++k) {
      PlaneEvidence side = plane(Vec3::UnitX(), 1);
      side.weight = 75.0;
      side.lever_odom_m = Vec3(apart_m * k, 2.5, 0.0);
      all.push_back(side);
    }
    return direction_information(information_of(all), all, Mat3::Identity(), Axes::Identity(),
                                 AwareSettings{});
  };
  // 4 x 75 = 300 1/m^2: more than 2 times the chance information, less than 5 times.
  const auto apart = reported(5.0);
  EXPECT_EQ(apart[0].planes, 4);
  EXPECT_EQ(apart[0].clusters, 4);
  EXPECT_NEAR(apart[0].noise, expected, 0.1);
  EXPECT_NEAR(apart[0].information, 300.0 - 2.0 * expected, 0.5);
  const auto together = reported(0.2);  // a single object that may move
  EXPECT_EQ(together[0].planes, 4);
  EXPECT_EQ(together[0].clusters, 1);
  EXPECT_EQ(together[0].information, 0.0);
}

/// Planes of a pipe that is bent by `radpm` per metre to the left, seen from `below_m` under its
/// axis; each normal is off by about a degree.
std::vector<PlaneEvidence> pipe(double radius_m, double radpm, double below_m) {
  Rng rng(7, "pipe");
  constexpr double kOff_rad = 0.0175;
  std::vector<PlaneEvidence> planes;
  for (double along_m = -20.0; along_m <= 20.0; along_m += 0.8) {
    const Mat3 turn = so3_exp(Vec3(0.0, 0.0, along_m * radpm));
    const Vec3 ahead = turn * Vec3::UnitX();
    const Vec3 left = turn * Vec3::UnitY();
    const Vec3 centre(radpm == 0.0 ? along_m : std::sin(along_m * radpm) / radpm,
                      radpm == 0.0 ? 0.0 : (1.0 - std::cos(along_m * radpm)) / radpm, below_m);
    for (int k = 0; k < 12; ++k) {
      const double angle = (k + 0.5) * std::numbers::pi / 6.0;
      const Vec3 n = std::cos(angle) * left + std::sin(angle) * Vec3::UnitZ();
      const Vec3 around = n.cross(ahead);
      PlaneEvidence p;
      p.n_odom = (n + kOff_rad * (rng.normal() * ahead + rng.normal() * around)).normalized();
      p.lever_odom_m = centre + radius_m * n;
      p.weight = 5e3;
      p.normal_covariance =
          kOff_rad * kOff_rad * (ahead * ahead.transpose() + around * around.transpose());
      p.points = 20;
      planes.push_back(p);
    }
  }
  return planes;
}

/// Information of a scan whose points lie in the middle of each plane; the body is not turned.
Mat6 information_with_arms(const std::vector<PlaneEvidence>& planes) {
  Mat6 I = Mat6::Zero();
  for (const PlaneEvidence& p : planes) {
    Vec6 row;
    row << p.lever_odom_m.cross(p.n_odom), p.n_odom;
    I += p.weight * row * row.transpose();
  }
  return I;
}

TEST(LeastMotion, is_a_screw_with_the_curvature_of_the_pipe) {
  for (const double radpm : {1.0 / 300.0, -0.01}) {
    auto planes = pipe(2.4, radpm, 1.0);
    const Vec6 u =
        least_motion(information_with_arms(planes), 0, Mat3::Identity(), Axes::Identity());
    EXPECT_NEAR(u[2], radpm, 5e-4);
    EXPECT_NEAR(u[1], 0.0, 5e-4) << "the pipe has no gradient";
    EXPECT_EQ(u[0], 0.0) << "roll";
    EXPECT_EQ(Vec3(u.tail<3>()), Vec3(Vec3::UnitX()));
  }
}

TEST(DirectionInformation, is_zero_along_a_bent_pipe_of_any_radius) {
  for (const double radius_m : {60.0, 100.0, 150.0, 300.0, 1000.0}) {
    auto planes = pipe(2.4, 1.0 / radius_m, 1.0);
    const auto bare = direction_information(information_with_arms(planes), planes, Mat3::Identity(),
                                            Axes::Identity(), AwareSettings{});
    EXPECT_NEAR(bare[0].raw / bare[0].noise, 1.0, 0.3) << radius_m;
    EXPECT_EQ(bare[0].information, 0.0) << radius_m;
    EXPECT_EQ(bare[1].category, Category::kFull) << radius_m;
    EXPECT_EQ(bare[2].category, Category::kFull) << radius_m;
    EXPECT_EQ(bare[5].category, Category::kFull) << radius_m;
    // The end of the pipe, 15 m ahead.
    for (int k = -1; k <= 1; ++k) {
      PlaneEvidence wall = plane(Vec3::UnitX(), 20);
      wall.lever_odom_m = Vec3(15.0, 1.6 * k, 1.0);
      planes.push_back(wall);
    }
    const auto closed = direction_information(information_with_arms(planes), planes,
                                              Mat3::Identity(), Axes::Identity(), AwareSettings{});
    EXPECT_EQ(closed[0].category, Category::kFull) << radius_m;
  }
}

TEST(DirectionInformation, constrains_shifts_across_a_round_pipe_wherever_the_sensor_is) {
  for (const double below_m : {0.0, 0.3, 1.0}) {
    const auto planes = pipe(1.5, 0.0, below_m);
    const auto out = direction_information(information_with_arms(planes), planes, Mat3::Identity(),
                                           Axes::Identity(), AwareSettings{});
    EXPECT_EQ(out[0].information, 0.0) << below_m;
    EXPECT_EQ(out[1].category, Category::kFull) << below_m;
    EXPECT_EQ(out[2].category, Category::kFull) << below_m;
    EXPECT_EQ(out[4].category, Category::kFull) << below_m;
    EXPECT_EQ(out[5].category, Category::kFull) << below_m;
  }
}

TEST(PhysicalAxes, first_axis_is_the_least_observable_horizontal_direction) {
  Mat6 I = Mat6::Identity();
  const Vec3 along(std::cos(0.4), std::sin(0.4), 0.0);
  const Vec3 across(-std::sin(0.4), std::cos(0.4), 0.0);
  I.block<3, 3>(3, 3) = 1.0 * along * along.transpose() + 100.0 * across * across.transpose() +
                        1000.0 * Vec3::UnitZ() * Vec3::UnitZ().transpose();
  const Axes axes = physical_axes(I, kGravity, Mat3::Identity(), Axes::Identity(), {});
  EXPECT_LT((axes.col(0) - along).norm(), 1e-12);
  EXPECT_LT((axes.col(1) - across).norm(), 1e-12);
  EXPECT_LT((axes.col(2) - Vec3::UnitZ()).norm(), 1e-12);
  // The sign follows the last scan, because an axis has no sign of its own.
  Axes opposite = axes;
  opposite.col(0) *= -1.0;
  EXPECT_LT((physical_axes(I, kGravity, Mat3::Identity(), opposite, {}).col(0) + along).norm(),
            1e-12);
}

TEST(PhysicalAxes, keep_the_previous_axes_when_no_horizontal_direction_is_clearly_weakest) {
  Mat6 I = Mat6::Identity();
  I(3, 3) = 3.9;
  Axes previous = so3_exp(Vec3(0.0, 0.0, 1.0));
  EXPECT_LT((physical_axes(I, kGravity, Mat3::Identity(), previous, {}) - previous).norm(), 1e-12);
  const Mat6 none = Mat6::Zero();
  EXPECT_LT((physical_axes(none, kGravity, Mat3::Identity(), previous, {}) - previous).norm(),
            1e-12);
}

/// Of planes by their normals, each known to 1.6 mm.
Mat6 information_of_normals(const std::vector<Vec3>& normals) {
  Mat6 I = Mat6::Zero();
  I.topLeftCorner<3, 3>() = 1e6 * Mat3::Identity();
  for (const Vec3& n : normals) I.bottomRightCorner<3, 3>() += 4e5 * n * n.transpose();
  return I;
}

/// A passage along x that rises by `slope` per metre.
Mat6 inclined_passage(double slope) {
  return information_of_normals({Vec3::UnitY(), Vec3(-slope, 0.0, 1.0).normalized()});
}

TEST(PhysicalAxes, rise_along_an_inclined_passage) {
  for (const double slope : {0.08, 0.14, -0.3}) {
    const Mat6 I = inclined_passage(slope);
    const Axes axes = physical_axes(I, kGravity, Mat3::Identity(), Axes::Identity(), {});
    EXPECT_NEAR(axes(2, 0) / axes(0, 0), slope, 0.01 * std::abs(slope)) << slope;
    EXPECT_LT((axes.transpose() * axes - Mat3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
    EXPECT_LT((axes.col(1) - Vec3::UnitY()).norm(), 1e-9);
    const auto sigma_along_m = [&I](const Vec3& d) {
      return 1.0 / std::sqrt(d.dot(I.bottomRightCorner<3, 3>() * d));
    };
    EXPECT_GT(sigma_along_m(axes.col(0)), 0.5) << slope;
    EXPECT_LT(sigma_along_m(Vec3::UnitX()), 0.021) << "if it had to be horizontal";
  }
}

TEST(PhysicalAxes, are_level_up_to_the_slope_that_errors_of_normals_give) {
  for (const double slope : {0.0, 0.02, -0.02}) {
    const Axes axes =
        physical_axes(inclined_passage(slope), kGravity, Mat3::Identity(), Axes::Identity(), {});
    EXPECT_LT((axes - Axes::Identity()).norm(), 1e-9) << slope;
  }
}

TEST(PhysicalAxes, stay_level_along_a_round_pipe_wherever_the_sensor_is) {
  for (const double below_m : {0.0, 0.3, 1.0}) {
    const Mat6 I = information_with_arms(pipe(1.5, 0.0, below_m));
    const Axes axes = physical_axes(I, kGravity, Mat3::Identity(), Axes::Identity(), {});
    EXPECT_GT(axes(0, 0), 0.99) << below_m << "\n" << axes;
    EXPECT_NEAR(axes(2, 0), 0.0, 1e-12) << below_m << "\n" << axes;
  }
}

TEST(PhysicalAxes, have_no_slope_if_the_scan_does_not_see_the_vertical) {
  // Two walls and no ground: the errors of the normals would give a slope of 45 degrees.
  const Mat6 I = information_of_normals({Vec3(0.0, 1.0, 0.0), Vec3(0.0001, 1.0, 0.0001)});
  const Axes axes = physical_axes(I, kGravity, Mat3::Identity(), Axes::Identity(), {});
  EXPECT_LT((axes.col(0) - Vec3::UnitX()).norm(), 1e-3);
}

TEST(PhysicalAxes, are_horizontal_on_level_ground_under_any_gravity) {
  Rng rng(2, "axes");
  for (int k = 0; k < 30; ++k) {
    const Vec3 g = 9.81 * Vec3(rng.normal(), rng.normal(), rng.normal()).normalized();
    const Vec3 wall = g.cross(Vec3(rng.normal(), rng.normal(), rng.normal())).normalized();
    const Mat6 I = information_of_normals({g.normalized(), wall});
    const Axes axes = physical_axes(I, g, Mat3::Identity(), Axes::Identity(), {});
    EXPECT_LT((axes.transpose() * axes - Mat3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
    EXPECT_LT((axes.col(2) + g.normalized()).norm(), 1e-9);
    EXPECT_LT(std::abs(axes.col(0).dot(wall)), 1e-9);
  }
}

Report scan_with(Category axial) {
  Report report;
  report.directions[0].category = axial;
  report.directions[0].direction_odom = Vec3::UnitX();
  report.directions[0].sigma = axial == Category::kNone ? 0.5 : 0.01;
  report.directions[1].sigma = report.directions[2].sigma = 0.005;
  return report;
}

TEST(CategoryFilter, worsens_after_two_scans_and_recovers_after_five) {
  CategoryFilter filter{AwareSettings{}};
  const auto next = [&filter](Category c) {
    Report report = scan_with(c);
    filter.apply(report);
    EXPECT_EQ(report.degenerate, report.directions[0].category == Category::kNone);
    return report.directions[0].category;
  };
  EXPECT_EQ(next(Category::kFull), Category::kFull);
  EXPECT_EQ(next(Category::kNone), Category::kFull);
  EXPECT_EQ(next(Category::kFull), Category::kFull);  // one bad scan does not change the category
  EXPECT_EQ(next(Category::kNone), Category::kFull);
  EXPECT_EQ(next(Category::kNone), Category::kNone);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(next(Category::kFull), Category::kNone) << k;
  EXPECT_EQ(next(Category::kFull), Category::kFull);
}

TEST(CategoryFilter, reports_the_least_observable_translation_direction) {
  CategoryFilter filter{AwareSettings{}};
  Report report = scan_with(Category::kNone);
  filter.apply(report);
  EXPECT_TRUE(report.degenerate);
  EXPECT_DOUBLE_EQ(report.sigma_degenerate_m, 0.5);
  EXPECT_EQ(report.degenerate_odom, Vec3(Vec3::UnitX()));
}

}  // namespace
}  // namespace rali::degeneracy
