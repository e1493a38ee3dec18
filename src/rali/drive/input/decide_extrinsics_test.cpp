#include <cmath>
#include <numbers>

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

constexpr double kDeg = std::numbers::pi / 180.0;

/// Points of a plane through `middle` spanned by u and v, seen by a LiDAR that is turned by
/// R_body_lidar.
void add_plane(const Vec3& middle, const Vec3& u, const Vec3& v, const geometry::Mat3& R_body_lidar,
               sensor::LidarScan& scan) {
  for (double a = -1.0; a < 1.0; a += 0.015) {
    for (double b = -1.0; b < 1.0; b += 0.015) {
      const Vec3 p = R_body_lidar.transpose() * (middle + a * u + b * v);
      scan.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                     static_cast<float>(p.z()), 0.0F, 0.0F, 0);
    }
  }
}

sensor::LidarScan yard_seen(const geometry::Mat3& R_body_lidar) {
  sensor::LidarScan scan;
  add_plane({0.0, 0.0, -1.0}, {10.0, 0.0, 0.0}, {0.0, 10.0, 0.0}, R_body_lidar, scan);
  return scan;
}

/// Two walls, and a little of an uneven floor.
sensor::LidarScan passage_seen() {
  sensor::LidarScan scan;
  const geometry::Mat3 I = geometry::Mat3::Identity();
  for (const double side : {-1.0, 1.0}) {
    add_plane({0.0, 1.5 * side, 0.5}, {12.0, 0.0, 0.0}, {0.0, 0.0, 1.5}, I, scan);
  }
  add_plane({4.0, 0.0, -1.0}, {2.5, 0.0, 0.9}, {0.0, 0.9, 0.0}, I, scan);
  return scan;
}

/// Of a vehicle at rest for two seconds on level ground.
std::vector<sensor::ImuSample> at_rest() {
  std::vector<sensor::ImuSample> samples;
  for (int k = 0; k < 400; ++k) {
    samples.push_back({Time::from_s(0.005 * k), Vec3::Zero(), Vec3(0.0, 0.0, 9.81)});
  }
  return samples;
}

Status decided(const InputOptions& options, const sensor::LidarScan& scan, InputReport& report) {
  return decide_extrinsics(options, {}, {&scan, 1}, at_rest(), {}, report);
}

double turned_deg(const InputReport& report, const geometry::Mat3& R) {
  return geometry::so3_log(report.T_body_lidar.R.transpose() * R).norm() / kDeg;
}

imu::MountingByTurning turning(imu::MountingVerdict verdict, const geometry::Mat3& R) {
  return {verdict, R, 0.4, 0.02};
}

TEST(DecideExtrinsics, an_unknown_mounting_is_turned_upright_by_the_ground_of_a_yard) {
  const geometry::Mat3 R = geometry::rotation_from_rpy(0.0, 25.0 * kDeg, 0.0);
  InputReport report = report_of_frames();
  ASSERT_TRUE(decided({}, yard_seen(R), report));
  EXPECT_EQ(report.T_body_lidar_origin, "ground");
  EXPECT_LT(turned_deg(report, R), 1.0);
  EXPECT_TRUE(report.mounting_in_question);
}

TEST(DecideExtrinsics, an_unknown_mounting_is_not_turned_by_walls_without_a_floor) {
  InputReport report = report_of_frames();
  ASSERT_TRUE(decided({}, passage_seen(), report));
  EXPECT_EQ(report.T_body_lidar_origin, "assumed zero");
  EXPECT_TRUE(report.T_body_lidar.R.isIdentity());
}

TEST(DecideExtrinsics, the_turning_overrules_the_ground) {
  const geometry::Mat3 R = geometry::rotation_from_rpy(0.0, 25.0 * kDeg, 0.0);
  InputOptions options;
  options.mounting = turning(imu::MountingVerdict::kAgrees, geometry::Mat3::Identity());
  InputReport on_slope = report_of_frames();
  ASSERT_TRUE(decided(options, yard_seen(R), on_slope));
  EXPECT_EQ(on_slope.T_body_lidar_origin, "assumed zero") << "the yard is a slope";
  options.mounting = turning(imu::MountingVerdict::kContradicts, R);
  InputReport tilted = report_of_frames();
  ASSERT_TRUE(decided(options, passage_seen(), tilted));
  EXPECT_EQ(tilted.T_body_lidar_origin, "turning");
  EXPECT_LT(turned_deg(tilted, R), 1e-6);
}

TEST(DecideExtrinsics, the_turning_does_not_overrule_a_large_ground_below_an_unknown_mounting) {
  InputOptions options;
  options.mounting = turning(imu::MountingVerdict::kContradicts,
                             geometry::rotation_from_rpy(0.0, 25.0 * kDeg, 0.0));
  InputReport report = report_of_frames();
  ASSERT_TRUE(decided(options, yard_seen(geometry::Mat3::Identity()), report));
  EXPECT_EQ(report.T_body_lidar_origin, "assumed zero");
  // The ground says nothing about a turn to the left.
  options.mounting.R_imu_lidar = geometry::rotation_from_rpy(0.0, 0.0, 90.0 * kDeg);
  InputReport turned = report_of_frames();
  ASSERT_TRUE(decided(options, yard_seen(geometry::Mat3::Identity()), turned));
  EXPECT_EQ(turned.T_body_lidar_origin, "turning");
}

TEST(DecideExtrinsics, a_given_mounting_is_refused_if_turning_and_ground_contradict_it) {
  const geometry::Mat3 R = geometry::rotation_from_rpy(0.0, 25.0 * kDeg, 0.0);
  InputOptions options;
  options.T_body_lidar = geometry::SE3{};
  options.mounting = turning(imu::MountingVerdict::kContradicts, R);
  InputReport report = report_of_frames();
  const Status refused = decided(options, yard_seen(R), report);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("rpy_deg: [0.0, 25.0, 0.0] fits"), std::string::npos)
      << refused.error().what;
  // By the turning alone it is questioned: a LiDAR odometry may have been led astray.
  InputReport warned = report_of_frames();
  ASSERT_TRUE(decided(options, yard_seen(geometry::Mat3::Identity()), warned));
  EXPECT_EQ(warned.findings.front().severity, Severity::kWarning);
  EXPECT_TRUE(warned.T_body_lidar.R.isIdentity()) << "what the user gives is used";
}

TEST(DecideExtrinsics, the_ground_refuses_nothing_before_the_turning_is_known) {
  InputOptions options;
  options.T_body_lidar = geometry::SE3{};
  const sensor::LidarScan steep = yard_seen(geometry::rotation_from_rpy(0.0, 1.0, 0.0));
  InputReport report = report_of_frames();
  EXPECT_FALSE(decided(options, steep, report));
  options.turning_follows = true;
  InputReport asked = report_of_frames();
  ASSERT_TRUE(decided(options, steep, asked));
  EXPECT_TRUE(asked.mounting_in_question);
}

}  // namespace
}  // namespace rali::drive
