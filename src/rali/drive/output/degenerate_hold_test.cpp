#include "rali/drive/output/degenerate_hold.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

vehicle::PoseEstimate pose_at(double t_s, bool degenerate, bool by_range = false) {
  vehicle::PoseEstimate pose;
  pose.t = Time::from_s(t_s);
  pose.degeneracy.degenerate = degenerate;
  if (by_range) pose.range_from = VehicleId{1};
  return pose;
}

TEST(DegenerateHold, is_by_range_for_2_s_then_imu_for_3_s) {
  DegenerateHold hold;
  EXPECT_EQ(hold.see(pose_at(0.0, false), true), HeldBy::kLidar);
  EXPECT_EQ(hold.see(pose_at(1.0, true, true), true), HeldBy::kRange);
  EXPECT_EQ(hold.see(pose_at(3.0, true), true), HeldBy::kRange);
  EXPECT_EQ(hold.see(pose_at(3.1, true), true), HeldBy::kImu);
  EXPECT_EQ(hold.see(pose_at(6.0, true), true), HeldBy::kImu);
  EXPECT_EQ(hold.see(pose_at(6.1, true), true), HeldBy::kNothing);
  EXPECT_EQ(hold.see(pose_at(6.2, true, true), true), HeldBy::kRange) << "found again";
}

TEST(DegenerateHold, without_inertial_data_is_by_nothing_except_at_standstill) {
  DegenerateHold hold;
  EXPECT_EQ(hold.see(pose_at(0.0, true), false), HeldBy::kNothing) << "blind from the start";
  vehicle::PoseEstimate standing = pose_at(1.0, true);
  standing.at_rest = true;
  EXPECT_EQ(hold.see(standing, false), HeldBy::kImu);
  EXPECT_EQ(hold.see(pose_at(1.1, true), false), HeldBy::kNothing);
}

TEST(DegenerateHold, is_by_nothing_for_a_diverged_pose) {
  DegenerateHold hold;
  vehicle::PoseEstimate lost = pose_at(0.0, false);
  lost.quality = vehicle::PoseQuality::kDiverged;
  EXPECT_EQ(hold.see(lost, true), HeldBy::kNothing);
}

}  // namespace
}  // namespace rali::drive
