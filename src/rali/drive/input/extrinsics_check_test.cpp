#include "rali/drive/input/extrinsics_check.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kDeg = std::numbers::pi / 180.0;

/// A floor 1 m below the sensor, 20 m x 20 m, as scanned by a LiDAR rotated by R_body_lidar.
sensor::LidarScan floor_seen(const Mat3& R_body_lidar) {
  sensor::LidarScan scan;
  for (double x = -10.0; x < 10.0; x += 0.15) {
    for (double y = -10.0; y < 10.0; y += 0.15) {
      const Vec3 p = R_body_lidar.transpose() * Vec3(x, y, -1.0);
      scan.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                     static_cast<float>(p.z()), 0.0F, 0.0F, 0);
    }
  }
  return scan;
}

std::vector<PlaneDirection> planes_of(const Mat3& R_body_lidar) {
  const sensor::LidarScan scan = floor_seen(R_body_lidar);
  return plane_directions({&scan, 1});
}

enum class Verdict { kAccepted, kWarned, kRefused };

/// Of the identity as T_body_lidar.
Verdict verdict_on(const std::vector<PlaneDirection>& planes) {
  const auto checked = check_extrinsics(planes, Mat3::Identity(), Vec3::UnitZ(), {});
  if (!checked) return Verdict::kRefused;
  return checked->empty() ? Verdict::kAccepted : Verdict::kWarned;
}

TEST(Extrinsics, finds_the_ground_below_a_tilted_lidar) {
  const Mat3 R = geometry::rotation_from_rpy(0.0, 30.0 * kDeg, 0.0);
  const auto planes = planes_of(R);
  ASSERT_FALSE(planes.empty());
  EXPECT_NEAR(*ground_tilt_rad(planes, R, Vec3::UnitZ()), 0.0, 0.5 * kDeg);
  EXPECT_NEAR(*ground_tilt_rad(planes, Mat3::Identity(), Vec3::UnitZ()), 30.0 * kDeg, 0.5 * kDeg);
}

TEST(Extrinsics, accepts_correct_extrinsics_also_on_a_10_deg_ramp) {
  const Mat3 R = geometry::rotation_from_rpy(0.0, 30.0 * kDeg, 0.0);
  const auto planes = planes_of(R);
  EXPECT_TRUE(check_extrinsics(planes, R, Vec3::UnitZ(), {}));
  const Vec3 up_on_a_ramp = Vec3(std::sin(10.0 * kDeg), 0.0, std::cos(10.0 * kDeg));
  EXPECT_TRUE(check_extrinsics(planes, R, up_on_a_ramp, {}));
}

TEST(Extrinsics, suggests_the_inverse_rotation_if_that_fits) {
  const Mat3 R = geometry::rotation_from_rpy(0.0, 30.0 * kDeg, 0.0);
  const auto checked = check_extrinsics(planes_of(R), R.transpose(), Vec3::UnitZ(), {});
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, ErrorCode::kInput);
  EXPECT_NE(checked.error().remedy.find("The inverse fits"), std::string::npos);
}

TEST(Extrinsics, suggests_swapped_axes_if_these_fit) {
  Mat3 R;  // the LiDAR's x points up
  R << 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0;
  const auto checked = check_extrinsics(planes_of(R), Mat3::Identity(), Vec3::UnitZ(), {});
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().remedy.find("z of the body = x of the LiDAR"), std::string::npos)
      << checked.error().remedy;
}

TEST(Extrinsics, are_accepted_in_a_corridor_without_visible_floor) {
  // Two walls, no floor in reach of the rings: other axes would "fit" as well as the right ones.
  const std::vector<PlaneDirection> walls = {{Vec3::UnitY(), 0.5}, {-Vec3::UnitY(), 0.45}};
  EXPECT_EQ(verdict_on(walls), Verdict::kAccepted);
  EXPECT_EQ(verdict_on({{Vec3::UnitY(), 0.3}, {-Vec3::UnitY(), 0.3}, {Vec3(0.5, 0.0, 0.866), 0.4}}),
            Verdict::kWarned);
  EXPECT_EQ(verdict_on({{Vec3::UnitY(), 0.9}}), Verdict::kRefused);
}

TEST(Extrinsics, are_accepted_where_a_lidar_sees_the_ceiling_and_one_wall) {
  // A sensor that looks up, on a spiral ramp: nothing contradicts its axes.
  const std::vector<PlaneDirection> seen = {{-Vec3::UnitZ(), 0.5}, {Vec3::UnitY(), 0.3}};
  EXPECT_TRUE(check_extrinsics(seen, Mat3::Identity(), Vec3::UnitZ(), {}));
  const std::vector<PlaneDirection> ceiling = {{-Vec3::UnitZ(), 0.9}};
  EXPECT_FALSE(check_extrinsics(ceiling, Mat3::Identity(), Vec3::UnitZ(), {})) << "upside down?";
}

TEST(Extrinsics, are_questioned_but_not_refused_between_slopes) {
  // A road on a hillside: rings see the slopes, one rising by 50 %, one falling by 45 %.
  EXPECT_EQ(verdict_on({{Vec3(0.0, 0.447, 0.894), 0.5}, {Vec3(0.0, 0.41, 0.912), 0.3}}),
            Verdict::kWarned);
  // In an inclined passage, its walls would be level under other axes.
  const std::vector<PlaneDirection> incline = {
      {Vec3::UnitY(), 0.35}, {-Vec3::UnitY(), 0.3}, {Vec3(-0.5, 0.0, 0.866), 0.3}};
  const auto checked = check_extrinsics(incline, Mat3::Identity(), Vec3::UnitZ(), {});
  ASSERT_TRUE(checked) << checked.error().message();
  ASSERT_EQ(checked->size(), 1U);
  EXPECT_NE(checked->front().remedy.find("slope"), std::string::npos);
  // Steeper than any slope.
  EXPECT_EQ(verdict_on({{Vec3(0.0, 0.707, 0.707), 0.8}}), Verdict::kRefused);
}

TEST(Extrinsics, are_not_judged_by_small_planes) {
  // A rough drift, seen by a dome: all planes are small, one of the roof is level.
  EXPECT_EQ(verdict_on({{Vec3(0.3, -0.94, 0.15), 0.13},
                        {Vec3(0.0, 0.04, -0.999), 0.10},
                        {Vec3(-0.9, 0.3, 0.32), 0.09},
                        {Vec3(-0.6, -0.5, -0.62), 0.09}}),
            Verdict::kAccepted);
  // The walls of an inclined passage are large, but no ground; its floor is small.
  EXPECT_EQ(verdict_on({{Vec3(0.0, -0.99, -0.15), 0.30},
                        {Vec3(0.0, 0.98, -0.19), 0.29},
                        {Vec3(-0.34, 0.0, 0.94), 0.11},
                        {Vec3(0.32, 0.0, -0.95), 0.09},
                        {Vec3(0.2, 0.72, -0.66), 0.08},
                        {Vec3(0.22, -0.68, -0.7), 0.08}}),
            Verdict::kAccepted);
}

TEST(Extrinsics, are_accepted_in_a_pipe_without_visible_floor) {
  // Sixteen level rings in a pipe of 1.6 m: its sides, and what is beside the floor and the top.
  const std::vector<PlaneDirection> pipe = {{Vec3(0.0, 1.0, -0.03), 0.23},
                                            {Vec3(0.01, -1.0, -0.01), 0.18},
                                            {Vec3(-0.06, -0.65, 0.76), 0.2},
                                            {Vec3(-0.04, 0.69, 0.72), 0.19},
                                            {Vec3(0.0, 0.53, -0.85), 0.2}};
  EXPECT_TRUE(check_extrinsics(pipe, Mat3::Identity(), Vec3::UnitZ(), {}));
  // A LiDAR that looks down in a pipe of 5 m: its lower sides, and the wall at its end.
  const std::vector<PlaneDirection> wide = {{Vec3::UnitX(), 0.24},
                                            {Vec3(0.01, 0.34, 0.94), 0.16},
                                            {Vec3(0.0, -0.35, 0.94), 0.16},
                                            {Vec3(0.01, 0.81, 0.58), 0.13},
                                            {Vec3(0.01, -0.82, 0.58), 0.13}};
  EXPECT_TRUE(check_extrinsics(wide, Mat3::Identity(), Vec3::UnitZ(), {}));
  // The section of a corridor has right angles; pitched, the floor does not run along the walls.
  const double h = std::sqrt(0.5);
  const std::vector<PlaneDirection> rolled = {{Vec3(0.0, h, h), 0.3},
                                              {Vec3(0.0, -h, h), 0.3},
                                              {Vec3(0.0, h, -h), 0.2},
                                              {Vec3(0.0, -h, -h), 0.2}};
  EXPECT_FALSE(check_extrinsics(rolled, Mat3::Identity(), Vec3::UnitZ(), {}));
  std::vector<PlaneDirection> cluttered = rolled;  // with something small and steep, as a car
  cluttered.push_back({Vec3(0.0, 1.0, 0.0), 0.08});
  EXPECT_FALSE(check_extrinsics(cluttered, Mat3::Identity(), Vec3::UnitZ(), {}));
  EXPECT_EQ(verdict_on({{Vec3::UnitY(), 0.3}, {-Vec3::UnitY(), 0.3}, {Vec3(h, 0.0, h), 0.4}}),
            Verdict::kRefused);
}

TEST(Extrinsics, are_accepted_in_a_vaulted_tunnel_without_visible_floor) {
  // Sixteen level rings in an arched tunnel 3.65 m wide: walls, the foot of the vault, its end.
  const std::vector<PlaneDirection> vault = {
      {Vec3(-0.02, -1.0, -0.07), 0.42},  {Vec3(0.01, 1.0, -0.07), 0.30},
      {Vec3(-0.04, -0.91, -0.42), 0.09}, {Vec3(0.99, 0.11, -0.01), 0.06},
      {Vec3(-0.04, -0.61, -0.79), 0.06}, {Vec3(0.01, 0.91, -0.41), 0.06}};
  EXPECT_TRUE(check_extrinsics(vault, Mat3::Identity(), Vec3::UnitZ(), {}));
  // The same, LiDAR rolled or pitched by 30 degrees: no walls, or oblique planes at its ends.
  for (const Vec3& rpy : {Vec3(30.0, 0.0, 0.0), Vec3(0.0, 30.0, 0.0)}) {
    const Mat3 R = geometry::rotation_from_rpy(rpy.x() * kDeg, rpy.y() * kDeg, 0.0);
    std::vector<PlaneDirection> turned = vault;
    turned.push_back({Vec3::UnitZ(), 0.3});  // the floor, farther away
    for (PlaneDirection& plane : turned) plane.n_lidar = R * plane.n_lidar;
    EXPECT_NE(verdict_on(turned), Verdict::kAccepted) << rpy;
  }
  // Walls before and behind stand upright beside a rolled ground, too.
  EXPECT_EQ(verdict_on({{Vec3::UnitX(), 0.2}, {-Vec3::UnitX(), 0.2}, {Vec3(0.0, 0.5, 0.866), 0.5}}),
            Verdict::kWarned);
}

TEST(Extrinsics, continue_with_a_finding_in_warn_mode) {
  const Mat3 R = geometry::rotation_from_rpy(0.0, 30.0 * kDeg, 0.0);
  InputOptions options;
  options.extrinsics = ExtrinsicsCheck::kWarn;
  const auto checked = check_extrinsics(planes_of(R), Mat3::Identity(), Vec3::UnitZ(), options);
  ASSERT_TRUE(checked);
  ASSERT_EQ(checked->size(), 1U);
  EXPECT_EQ(checked->front().id, "D11");
  EXPECT_NEAR(checked->front().value, 30.0, 0.5);
}

TEST(Extrinsics, are_accepted_without_planes) {
  EXPECT_FALSE(ground_tilt_rad({}, Mat3::Identity(), Vec3::UnitZ()));
  EXPECT_TRUE(check_extrinsics({}, Mat3::Identity(), Vec3::UnitZ(), {}));
}

TEST(Extrinsics, are_reported_in_words) {
  geometry::SE3 T;
  T.p = {0.08, 0.0, 0.25};
  T.R = geometry::rotation_from_rpy(0.0, 0.0, 1.5 * kDeg);
  EXPECT_EQ(extrinsics_in_words(T), "0.08 m forward, 0.25 m up of the IMU, turned 1.5 deg left");
}

}  // namespace
}  // namespace rali::drive
