#include "rali/fleet/frames/frame_solver.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/fleet/frames/track_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;
using geometry::Vec3;

/// Vehicles on given paths (in their odom frames), a point a second; at the end they stop.
struct World {
  std::vector<StreamKey> keys;
  std::vector<YawPose> T_world_odom;
  std::vector<std::vector<Vec2>> paths;
  Rng rng{7, "fleet"};

  void add(std::uint16_t id, const YawPose& T, const std::vector<Vec2>& path) {
    keys.push_back({VehicleId{id}, 0});
    T_world_odom.push_back(T);
    paths.push_back(path);
  }

  [[nodiscard]] YawPose T(std::size_t ref, std::size_t v) const {
    return T_world_odom[ref].inverse() * T_world_odom[v];
  }

  /// @param excess_m by which the range is too long
  void range(std::size_t i, std::size_t a, std::size_t b, FrameSolver& solver,
             double excess_m = 0.0, double later_s = 0.0, double sigma_m = 0.07) {
    RangeObservation o;
    o.t = Time::from_s(later_s + static_cast<double>(i));
    o.x_a_m.head<2>() = paths[a][std::min(i, paths[a].size() - 1)];
    o.y_b_m.head<2>() = paths[b][std::min(i, paths[b].size() - 1)];
    o.range_m = (T_world_odom[a] * o.x_a_m - T_world_odom[b] * o.y_b_m).norm() + 0.05 + excess_m +
                0.07 * rng.normal();
    o.sigma_m = sigma_m;
    solver.add_range(keys[a], keys[b], o);
  }
};

std::vector<Vec2> turning(double sign, double x, double y) {
  return along({{0, 0}, {x, 0}, {x, sign * y}, {0.3 * x, sign * y}}, (1.7 * x + y) / 90.0);
}

World three() {
  World w;
  w.add(1, {0.0, Vec3(0, 0, 0)}, turning(-1.0, 8.0, 7.0));
  w.add(2, {0.7, Vec3(9, -2, 0)}, turning(1.0, 12.0, 6.0));
  w.add(3, {-2.2, Vec3(-5, 6, 0)}, along({{0, 0}, {6, 0}, {6, 7}, {11, 7}, {11, -3}}, 0.31));
  return w;
}

double error_m(const World& w, const FrameSolver& solver, std::size_t ref, std::size_t v) {
  const auto T = solver.T_ref_odom(w.keys[v]);
  if (!T) return 1e9;
  const Vec3 p(w.paths[v].front().x(), w.paths[v].front().y(), 0.0);
  return (*T * p - w.T(ref, v) * p).norm();
}

const VehicleNames kNames = {{VehicleId{1}, "ann"}, {VehicleId{2}, "ben"}, {VehicleId{3}, "cid"}};

TEST(FrameSolver, joins_a_vehicle_through_another_without_ranges_to_the_reference) {
  World w = three();
  FrameSolver solver(InitSettings{}, w.keys[0]);
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 0, 1, solver);
    w.range(i, 1, 2, solver);
    if (i % 3 == 0) solver.evaluate(Time::from_s(static_cast<double>(i)));
  }
  ASSERT_TRUE(solver.placed(w.keys[1]));
  ASSERT_TRUE(solver.placed(w.keys[2])) << solver.text(w.keys[2], kNames);
  EXPECT_LT(error_m(w, solver, 0, 1), 0.5);
  EXPECT_LT(error_m(w, solver, 0, 2), 0.7);
  const FleetFrames frames = solver.frames();
  ASSERT_EQ(frames.groups.size(), 1u);
  EXPECT_EQ(frames.groups[0].covariance.rows(), 8);
  EXPECT_GT(frames.groups[0].covariance.diagonal().minCoeff(), 0.0);
  // A vehicle placed through another shares its errors.
  EXPECT_GT(frames.groups[0].covariance.topRightCorner(4, 4).norm(), 1e-6);
  EXPECT_EQ(solver.text(w.keys[2], kNames), "cid: in the frame of ann");
}

TEST(FrameSolver, keeps_unconnected_groups_separate_and_reports_them) {
  World w = three();
  w.add(4, {1.0, Vec3(30, 30, 0)}, turning(-1.0, 3.0, 3.0));
  FrameSolver solver(InitSettings{}, w.keys[0]);
  solver.add_vehicle(w.keys[3]);
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 1, 2, solver);
    if (i % 3 == 0) solver.evaluate(Time::from_s(static_cast<double>(i)));
  }
  EXPECT_FALSE(solver.placed(w.keys[1]));
  ASSERT_EQ(solver.frames().groups.size(), 3u);
  EXPECT_EQ(solver.frames().groups[1].frames.keys.size(), 2u);
  EXPECT_EQ(solver.text(w.keys[1], kNames),
            "ben is tied to cid, but not to ann. ben: neither ranges nor common places with ann "
            "yet");
  EXPECT_EQ(solver.text(w.keys[3], kNames), "v4: neither ranges nor common places with ann yet");
  // Ranges of either connect both to the reference.
  std::reverse(w.paths[0].begin(), w.paths[0].end());
  std::reverse(w.paths[2].begin(), w.paths[2].end());
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 0, 2, solver, 0.0, 90.0);
    if (i % 3 == 0) solver.evaluate(Time::from_s(90.0 + static_cast<double>(i)));
  }
  EXPECT_TRUE(solver.placed(w.keys[1])) << solver.text(w.keys[1], kNames);
  EXPECT_LT(error_m(w, solver, 0, 1), 0.7);
}

TEST(FrameSolver, never_joins_a_vehicle_driving_straight_past_a_standing_one) {
  World w;
  w.add(1, YawPose{}, {{0, 0}});
  w.add(2, {0.4, Vec3(4, 3, 0)}, along({{0, 0}, {30, 0}}, 0.5));
  FrameSolver solver(InitSettings{}, w.keys[0]);
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 0, 1, solver);
    solver.evaluate(Time::from_s(2.0 * static_cast<double>(i)));
    EXPECT_FALSE(solver.placed(w.keys[1]));
  }
  EXPECT_EQ(solver.text(w.keys[1], kNames),
            "ben: left/right of ann unknown. Move ben off its line by 1 m");
}

TEST(FrameSolver, uses_a_prior_with_its_sigma_and_reports_that_it_decided) {
  World w;
  w.add(1, YawPose{}, {{0, 0}});
  w.add(2, {0.4, Vec3(4, 3, 0)}, along({{0, 0}, {15, 0}}, 0.5));
  FrameSolver solver(InitSettings{}, w.keys[0]);
  solver.add_evidence(prior_evidence(w.keys[1], w.keys[0], {0.38, Vec3(4.3, 2.8, 0)}, {}));
  InitSettings settings;
  settings.prior.yaw_deg = 1.0;
  settings.prior.xyz_m = 0.2;
  FrameSolver sharp(settings, w.keys[0]);
  sharp.add_evidence(prior_evidence(w.keys[1], w.keys[0], {0.395, Vec3(4.1, 2.9, 0)}, settings));
  for (std::size_t i = 0; i < 31; ++i) {
    w.range(i, 0, 1, solver);
    w.range(i, 0, 1, sharp);
    solver.evaluate(Time::from_s(2.0 * static_cast<double>(i)));
    sharp.evaluate(Time::from_s(2.0 * static_cast<double>(i)));
  }
  // The start pose is used with its sigma: the frame is joined, with this sigma of the heading.
  ASSERT_TRUE(solver.placed(w.keys[1]));
  const double yaw_sigma = std::sqrt(solver.frames().groups.front().covariance(0, 0));
  EXPECT_GT(yaw_sigma, 2.0 * kDegree);
  EXPECT_LT(yaw_sigma, 5.5 * kDegree);
  EXPECT_LT(std::sqrt(sharp.frames().groups.front().covariance(0, 0)), 1.1 * kDegree);
  EXPECT_EQ(sharp.text(w.keys[1], kNames), "ben: in the frame of ann, decided by the prior");
  EXPECT_LT(error_m(w, sharp, 0, 1), 0.5);
}

TEST(FrameSolver, a_prior_alone_joins_at_once_without_a_single_range) {
  World w;
  w.add(1, YawPose{}, {{0, 0}});
  w.add(2, {0.4, Vec3(4, 3, 0)}, {{0, 0}});
  FrameSolver solver(InitSettings{}, w.keys[0]);
  solver.add_evidence(prior_evidence(w.keys[1], w.keys[0], {0.4, Vec3(4, 3, 0)}, {}));
  solver.evaluate(Time::from_s(0.1));
  EXPECT_TRUE(solver.placed(w.keys[1]));
  EXPECT_EQ(solver.text(w.keys[1], kNames), "ben: in the frame of ann, decided by the prior");
}

TEST(FrameSolver, does_not_join_vehicles_whose_ranges_contradict_the_prior) {
  World w;
  w.add(1, YawPose{}, {{0, 0}});
  w.add(2, {0.4, Vec3(4, 3, 0)}, along({{0, 0}, {15, 0}}, 0.5));
  InitSettings settings;
  settings.prior.yaw_deg = 3.0;
  settings.prior.xyz_m = 0.2;
  FrameSolver solver(settings, w.keys[0]);
  // Wrong by 10 m: no pose within its sigmas fits the ranges.
  solver.add_evidence(prior_evidence(w.keys[1], w.keys[0], {0.4, Vec3(14, 3, 0)}, settings));
  for (std::size_t i = 0; i < 31; ++i) w.range(i, 0, 1, solver);
  solver.evaluate(Time::from_s(60.0));
  EXPECT_FALSE(solver.placed(w.keys[1]));
}

TEST(FrameSolver, ranges_around_a_corner_do_not_pull_off_a_start_pose) {
  World w;
  w.add(1, YawPose{}, {{0, 0}});
  w.add(2, {0.05, Vec3(10, 1, 0)}, along({{0, 0}, {4, 0}, {4, 14}}, 0.5));
  InitSettings settings;
  settings.prior.yaw_deg = 3.0;
  settings.prior.xyz_m = 0.2;
  FrameSolver solver(settings, w.keys[0]);
  const YawPose given{0.02, Vec3(10.1, 0.9, 0)};
  solver.add_evidence(prior_evidence(w.keys[1], w.keys[0], given, settings));
  for (std::size_t i = 0; i < 36; ++i) {
    w.range(i, 0, 1, solver, i < 10 ? 0.0 : 0.3 * (static_cast<double>(i) - 9.0));
  }
  solver.evaluate(Time::from_s(60.0));
  ASSERT_TRUE(solver.placed(w.keys[1]));
  EXPECT_LT(error_m(w, solver, 0, 1), 0.4);
  EXPECT_NEAR(solver.T_ref_odom(w.keys[1])->yaw_rad, 0.05, 0.157) << "3 sigma";
}

TEST(FrameSolver, a_long_row_of_blocked_ranges_does_not_overrule_start_poses) {
  // Two vehicles on a circle of 15 m, as on a ramp with rock in its middle, 60 degrees apart: after
  // seven metres in line of sight of the anchor and each other, their ranges are 3 m too long,
  // always alike. The first 14 degrees farther along the circle would fit them.
  const auto circle = [](double from_rad) {
    std::vector<Vec2> path;
    for (int i = 0; i < 240; ++i) {
      const double a = from_rad + i * 0.5 / 15.0;
      path.emplace_back(15.0 * (std::cos(a) - std::cos(from_rad)),
                        15.0 * (std::sin(a) - std::sin(from_rad)));
    }
    return path;
  };
  constexpr double kApart_rad = std::numbers::pi / 3.0;
  World w;
  w.add(1, {0.0, Vec3(13.0, -4.0, 0)}, {{0, 0}});
  w.add(2, {0.0, Vec3(15.0, 0, 0)}, circle(0.0));
  w.add(3, {0.0, Vec3(15.0 * std::cos(kApart_rad), -15.0 * std::sin(kApart_rad), 0)},
        circle(-kApart_rad));
  InitSettings settings;
  settings.prior.yaw_deg = 3.0;
  settings.prior.xyz_m = 0.1;
  FrameSolver solver(settings, w.keys[0]);
  for (const std::size_t v : {std::size_t{1}, std::size_t{2}}) {
    YawPose given = w.T(0, v);
    given.t_m += Vec3(0.05, -0.05, 0.0);
    solver.add_evidence(prior_evidence(w.keys[v], w.keys[0], given, settings));
  }
  for (std::size_t i = 0; i < 240; ++i) {
    const double slow = std::sin(0.05 * static_cast<double>(i));
    if (i < 14) {
      w.range(i, 0, 1, solver);
      w.range(i, 0, 2, solver);
      w.range(i, 1, 2, solver);
    } else {
      w.range(i, 1, 2, solver, 3.0 + 0.2 * slow, 0.0, 0.5);  // the sigma of a blocked path
    }
  }
  for (int k = 0; k < 6; ++k) solver.evaluate(Time::from_s(480.0 + 2.0 * k));
  ASSERT_TRUE(solver.placed(w.keys[1]));
  ASSERT_TRUE(solver.placed(w.keys[2]));
  for (const std::size_t v : {std::size_t{1}, std::size_t{2}}) {
    const Vec3 opposite(w.paths[v][94].x(), w.paths[v][94].y(), 0.0);  // 30 m from its start
    const auto T = solver.T_ref_odom(w.keys[v]);
    EXPECT_LT((*T * opposite - w.T(0, v) * opposite).norm(), 1.0) << "1.7 and 2.0 m without limit";
  }
}

TEST(FrameSolver, frames_do_not_depend_on_the_vehicle_ids) {
  World w = three();
  FrameSolver solver(InitSettings{}, w.keys[0]);
  World v = three();
  v.keys = {{VehicleId{40}, 0}, {VehicleId{7}, 3}, {VehicleId{21}, 0}};
  FrameSolver renamed(InitSettings{}, v.keys[0]);
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 0, 1, solver);
    w.range(i, 1, 2, solver);
    v.range(i, 0, 1, renamed);
    v.range(i, 1, 2, renamed);
    if (i % 3 != 0) continue;
    solver.evaluate(Time::from_s(static_cast<double>(i)));
    renamed.evaluate(Time::from_s(static_cast<double>(i)));
  }
  for (std::size_t k = 1; k < 3; ++k) {
    ASSERT_TRUE(renamed.placed(v.keys[k]));
    EXPECT_NEAR((renamed.T_ref_odom(v.keys[k])->t_m - solver.T_ref_odom(w.keys[k])->t_m).norm(),
                0.0, 1e-3);
  }
}

TEST(FrameSolver, takes_over_a_frame_from_another_fleet_mapper) {
  World w = three();
  FrameSolver solver(InitSettings{}, w.keys[0]);
  PoseEvidence known;
  known.a = w.keys[1];
  known.b = w.keys[0];
  known.yaw_rad = w.T(0, 1).yaw_rad;
  known.place_b_m = w.T(0, 1).t_m;
  known.information = Mat4::Identity() * 1e4;
  solver.place(known);
  ASSERT_TRUE(solver.placed(w.keys[1]));
  EXPECT_LT(error_m(w, solver, 0, 1), 1e-6);
  EXPECT_NEAR(solver.frames().groups[0].covariance(1, 1), 1e-4, 1e-6);
  // A late joiner receives only the other tag.
  for (std::size_t i = 0; i < 90; ++i) {
    w.range(i, 1, 2, solver);
    if (i % 3 == 0) solver.evaluate(Time::from_s(static_cast<double>(i)));
  }
  EXPECT_TRUE(solver.placed(w.keys[2])) << solver.text(w.keys[2], kNames);
}

}  // namespace
}  // namespace rali::fleet
