#include "rali/drive/output/joint_path.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

TEST(JointPath, transforms_keyframes_and_covariances_from_map_to_odom) {
  fleet::FleetEstimate estimate;
  fleet::VehicleFrame& frame = estimate.frames.emplace_back();
  frame.vehicle = VehicleId{1};
  frame.T_map_odom.R = geometry::rotation_from_rpy(0.0, 0.0, 1.5707963267948966);
  frame.T_map_odom.p = {10.0, 0.0, 0.0};
  fleet::KeyframePose& pose = estimate.keyframes[{VehicleId{1}, 3}];
  pose.T_map_body.p = {10.0, 2.0, 0.0};
  pose.covariance(3, 3) = 0.04;  // along x of the map, -y of odom
  const JointPath path = joint_path(estimate, VehicleId{1});
  ASSERT_EQ(path.keyframes.size(), 1U);
  const vehicle::KeyframeCorrected& corrected = path.keyframes.at(3);
  EXPECT_LT((corrected.T_local_body.p - geometry::Vec3(2.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(corrected.covariance(4, 4), 0.04, 1e-12);
  EXPECT_NEAR(corrected.covariance(3, 3), 0.0, 1e-12);
}

TEST(JointPath, puts_vehicles_without_a_path_in_groups_of_their_own) {
  fleet::FleetEstimate estimate;
  estimate.groups = {{VehicleId{1}}};
  estimate.frames.emplace_back().vehicle = VehicleId{1};
  add_absent(3, estimate);
  ASSERT_EQ(estimate.groups.size(), 3U);
  ASSERT_EQ(estimate.frames.size(), 3U);
  for (std::uint16_t i = 0; i < 3; ++i) EXPECT_EQ(estimate.frames[i].vehicle, VehicleId{i});
  EXPECT_EQ(estimate.frames[1].group, 0U);
  EXPECT_EQ(estimate.frames[0].waits_for, "it has no path");
}

}  // namespace
}  // namespace rali::drive
