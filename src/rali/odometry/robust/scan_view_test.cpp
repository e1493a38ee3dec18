#include "rali/odometry/robust/scan_view.hpp"

#include <gtest/gtest.h>

#include "rali/odometry/robust/rooms_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;

ScanView view_from(double x, double y, double yaw_rad) {
  const sensor::LidarScan scan = test::seen_from(test::two_rooms(), x, y, yaw_rad, Time{});
  BodyPoints points;
  ScanMotion(SE3{}).apply(scan, {}, points);
  return {points, Vec3::Zero()};
}

SE3 between(double x, double y, double yaw_rad, const SE3& T_world_b) {
  return test::upright_pose(x, y, yaw_rad).inverse() * T_world_b;
}

TEST(ScanView, has_low_conflict_at_the_true_pose) {
  const ScanView a = view_from(-2.0, 0.0, 0.0);
  const ScanView b = view_from(-1.5, 0.4, 40.0 * kDegree);
  const SE3 T_world_b = test::upright_pose(-1.5, 0.4, 40.0 * kDegree);
  const ViewAgreement seen = a.compare(b, between(-2.0, 0.0, 0.0, T_world_b));
  EXPECT_GT(seen.agree, 10000);
  EXPECT_LT(seen.conflict(), 0.05);
}

TEST(ScanView, has_higher_conflict_at_a_pose_rotated_by_30_degrees) {
  const ScanView a = view_from(-2.0, 0.0, 0.0);
  const ScanView b = view_from(-1.5, 0.4, 40.0 * kDegree);
  const SE3 T_wrong = test::upright_pose(-1.5, 0.4, 10.0 * kDegree);
  const double right =
      a.compare(b, between(-2.0, 0.0, 0.0, test::upright_pose(-1.5, 0.4, 40.0 * kDegree)))
          .conflict();
  EXPECT_GT(a.compare(b, between(-2.0, 0.0, 0.0, T_wrong)).conflict(), right + 0.1);
}

TEST(ScanView, has_low_conflict_for_an_occluded_room_behind_a_door) {
  const ScanView a = view_from(-1.0, 0.0, 0.0);
  const ScanView b = view_from(0.6, 0.0, 0.0);
  const SE3 T_world_b = test::upright_pose(0.6, 0.0, 0.0);
  EXPECT_LT(a.compare(b, between(-1.0, 0.0, 0.0, T_world_b)).conflict(), 0.1);
}

TEST(ScanView, has_zero_conflict_without_common_points) {
  const ScanView a = view_from(-1.0, 0.0, 0.0);
  const ScanView nothing(BodyPoints{}, Vec3::Zero());
  EXPECT_EQ(a.compare(nothing, SE3{}).conflict(), 0.0);
}

}  // namespace
}  // namespace rali::odometry
