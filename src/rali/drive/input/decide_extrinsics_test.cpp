#include <gtest/gtest.h>

#include "rali/drive/input/recording_probe.hpp"

namespace rali::drive {
namespace {

using geometry::SE3;
using geometry::Vec3;

SE3 at(double x_m, double y_m, double z_m) {
  SE3 T;
  T.p = Vec3(x_m, y_m, z_m);
  return T;
}

/// base_link with an IMU 0.1 m in front and a LiDAR 0.5 m above the IMU.
TfTree vehicle_tree(const std::string& body) {
  TfTree tree;
  tree.add({{}, body, "imu", at(0.1, 0.0, 0.2)});
  tree.add({{}, "imu", "lidar", at(0.0, 0.0, 0.5)});
  return tree;
}

InputReport report_of_frames() {
  InputReport report;
  report.vehicle = "v1";
  report.has_imu = true;
  report.imu_frame = "imu";
  report.lidar_frame = "lidar";
  return report;
}

TEST(DecideExtrinsics, the_imu_is_the_body_frame_by_default) {
  InputReport report = report_of_frames();
  ASSERT_TRUE(decide_extrinsics({}, vehicle_tree("base_link"), {}, {}, {}, report));
  EXPECT_TRUE(report.T_body_imu.p.isZero());
  EXPECT_TRUE(report.T_body_lidar.p.isApprox(Vec3(0.0, 0.0, 0.5)));
  EXPECT_EQ(report.T_body_imu_origin, "");
}

TEST(DecideExtrinsics, auto_and_from_tf_take_the_imu_pose_in_base_link) {
  for (const char* const frame : {"", "imu"}) {
    InputOptions options;
    options.imu_from_tf = true;
    options.imu_tf_frame = frame;
    InputReport report = report_of_frames();
    ASSERT_TRUE(decide_extrinsics(options, vehicle_tree("base_link"), {}, {}, {}, report));
    EXPECT_EQ(report.T_body_imu.p, Vec3(0.1, 0.0, 0.2));
    EXPECT_TRUE(report.T_body_lidar.p.isApprox(Vec3(0.1, 0.0, 0.7))) << "LiDAR in the same body";
    EXPECT_EQ(report.T_body_imu_origin, "/tf_static, imu in base_link");
  }
}

TEST(DecideExtrinsics, without_a_body_frame_auto_falls_back_and_from_tf_is_refused) {
  InputOptions options;
  options.imu_from_tf = true;
  InputReport report = report_of_frames();
  ASSERT_TRUE(decide_extrinsics(options, vehicle_tree("gimbal"), {}, {}, {}, report));
  EXPECT_TRUE(report.T_body_imu.p.isZero());
  EXPECT_TRUE(report.T_body_imu_origin.starts_with("body = IMU")) << report.T_body_imu_origin;
  options.imu_tf_frame = "imu";
  const Status refused = decide_extrinsics(options, vehicle_tree("gimbal"), {}, {}, {}, report);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "vehicles.v1.imu.T_body_imu.from_tf");
}

TEST(DecideExtrinsics, without_an_imu_from_tf_takes_the_lidar_pose_in_the_body) {
  InputOptions options;
  options.lidar_tf_frame = "lidar";
  InputReport report = report_of_frames();
  report.has_imu = false;
  report.imu_frame.clear();
  ASSERT_TRUE(decide_extrinsics(options, vehicle_tree("body"), {}, {}, {}, report));
  EXPECT_TRUE(report.T_body_lidar.p.isApprox(Vec3(0.1, 0.0, 0.7)));
  InputReport lost = report_of_frames();
  lost.has_imu = false;
  lost.imu_frame.clear();
  EXPECT_FALSE(decide_extrinsics(options, vehicle_tree("gimbal"), {}, {}, {}, lost));
}

}  // namespace
}  // namespace rali::drive
