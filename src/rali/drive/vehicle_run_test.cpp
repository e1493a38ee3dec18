#include "rali/drive/vehicle_run.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/drive/output/joint_path.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::drive {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

vehicle::PoseEstimate pose_at(double t_s, double x_m) {
  vehicle::PoseEstimate pose;
  pose.t = Time::from_s(t_s);
  pose.T_local_body.p = {x_m, 0.0, 0.0};
  pose.covariance = 1e-4 * geometry::Mat6::Identity();
  return pose;
}

vehicle::KeyframeAdded keyframe_at(double t_s, std::uint32_t seq) {
  auto keyframe = std::make_shared<odometry::Keyframe>();
  keyframe->t = Time::from_s(t_s);
  keyframe->cloud.x_m = {1.0F, 2.0F};
  keyframe->cloud.y_m = {0.5F, -0.5F};
  keyframe->cloud.z_m = {0.0F, 0.25F};
  keyframe->cloud.intensity = {7.0F, 8.0F};
  keyframe->cloud.ring = {3, 4};
  return {{VehicleId{0}, seq}, keyframe};
}

TEST(LevelFrame, turns_measured_gravity_down_and_the_first_pose_to_the_origin) {
  SE3 T_odom_first;
  T_odom_first.R = geometry::rotation_from_rpy(0.1, -0.05, 1.2);
  T_odom_first.p = {3.0, -2.0, 0.5};
  const Vec3 g_odom = Vec3(0.4, -0.3, -9.8);
  const SE3 T_map_local = level_frame(g_odom, T_odom_first);
  EXPECT_TRUE((T_map_local.R * g_odom).isApprox(Vec3(0.0, 0.0, -g_odom.norm()), 1e-12));
  const SE3 T_map_first = T_map_local * T_odom_first;
  EXPECT_NEAR(T_map_first.p.norm(), 0.0, 1e-12);
  EXPECT_NEAR(geometry::rpy_from_rotation(T_map_first.R).z(), 0.0, 1e-12) << "heads along +x";
}

TEST(LevelFrame, is_the_identity_where_odom_is_level_already) {
  const SE3 T_map_local = level_frame(Vec3(0.0, 0.0, -9.81), SE3{});
  EXPECT_TRUE(T_map_local.R.isApprox(Mat3::Identity()));
  EXPECT_TRUE(T_map_local.p.isZero());
}

TEST(VehicleRun, writes_all_poses_to_odometry_but_diverged_keyframes_not_to_the_map) {
  const io::TestFolder folder;
  Result<VehicleRun> run = VehicleRun::start("v1", folder.path(), nullptr);
  ASSERT_TRUE(run);
  FindingList findings;
  ASSERT_TRUE(run->take({pose_at(1.0, 0.0), keyframe_at(1.0, 0), pose_at(1.1, 0.5)}, findings));
  vehicle::PoseEstimate lost = pose_at(1.2, 90.0);
  lost.quality = vehicle::PoseQuality::kDiverged;
  ASSERT_TRUE(run->take({lost, keyframe_at(1.2, 1)}, findings));
  ASSERT_TRUE(run->finish());

  const auto tum = io::read_tum(folder.path("odometry/v1.tum"));
  ASSERT_TRUE(tum);
  EXPECT_EQ(tum->poses.size(), 3U) << "odometry tells all, diverged poses too";
  EXPECT_NEAR(run->path_m(), 0.5, 1e-12) << "the jump into nowhere is no way";
  VehicleSummary summary;
  run->summarise(summary);
  EXPECT_EQ(summary.keyframes, 1U);
  EXPECT_NEAR(summary.diverged_s, 0.1, 1e-9);
  EXPECT_NEAR(summary.sigma_median_m, std::sqrt(3e-4), 1e-12);

  const std::string out = folder.path();
  const auto stream = keyframe_stream(out, run->keyframes(), run->T_map_local());
  std::size_t seen = 0;
  ASSERT_TRUE(stream([&](const map::KeyframeView& view) {
    ++seen;
    ASSERT_EQ(view.size(), 2U);
    EXPECT_EQ(view.x_m[1], 2.0F);
    EXPECT_EQ(view.intensity[0], 7.0F);
    EXPECT_EQ(view.ring[1], 4);
  }));
  EXPECT_EQ(seen, 1U) << "the diverged keyframe is cut from the map";

  const std::string text = trajectory_text(run->poses(), run->map_frame(), "v1");
  EXPECT_NE(text.find("# cut from 1.200000000: diverged"), std::string::npos);
  EXPECT_EQ(io::parse_tum(text, "trajectory")->poses.size(), 2U);
}

TEST(VehicleRun, a_frame_is_levelled_only_with_inertial_data_in_its_group) {
  const io::TestFolder folder;
  std::vector<VehicleRun> runs;
  for (const bool inertial : {false, true, false}) {
    Result<VehicleRun> run =
        VehicleRun::start(fmt::format("v{}", runs.size() + 1), folder.path(), nullptr);
    ASSERT_TRUE(run);
    fleet::Increment step;
    step.levelled = inertial;
    FindingList findings;
    const vehicle::FactMade made{std::make_shared<const fleet::Fact>(fleet::Fact{{}, {}, step})};
    const vehicle::GravityEstimate down{
        VehicleId{0}, Time::from_s(1.0), {0.0, 0.0, -9.81}, geometry::Mat3::Zero()};
    ASSERT_TRUE(run->take({pose_at(1.0, 0.0), made, down}, findings));
    runs.push_back(std::move(*run));
  }
  fleet::FleetEstimate estimate;
  estimate.groups = {{VehicleId{0}, VehicleId{1}}, {VehicleId{2}}};
  share_levels(estimate, runs);
  for (VehicleRun& run : runs) ASSERT_TRUE(run.finish());
  EXPECT_TRUE(runs[0].map_frame().levelled) << "v2 levels the frame that they share";
  EXPECT_TRUE(runs[1].map_frame().levelled);
  EXPECT_FALSE(runs[2].map_frame().levelled) << "a default of -z is no measurement";
  EXPECT_TRUE(std::isnan(runs[2].tilt_sigma_rad()));
  EXPECT_EQ(runs[1].tilt_sigma_rad(), 0.0);
  const std::string text = trajectory_text(runs[2].poses(), runs[2].map_frame(), "v3");
  EXPECT_EQ(io::is_levelled(io::parse_tum(text, "v3.tum")->header), false);
}

TEST(VehicleRun, leaves_readable_odometry_if_it_is_not_finished) {
  const io::TestFolder folder;
  {
    Result<VehicleRun> run = VehicleRun::start("v1", folder.path(), nullptr);
    ASSERT_TRUE(run);
    FindingList findings;
    for (int i = 0; i < 300; ++i) {
      ASSERT_TRUE(run->take({pose_at(0.1 * i, 0.0)}, findings));
    }
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("odometry/v1.tum")));
  const auto tum = io::read_tum(folder.path("odometry/.v1.tum.tmp"));
  ASSERT_TRUE(tum) << tum.error().message();
  EXPECT_GE(tum->poses.size(), 200U) << "at most 10 s of data late";
}

TEST(VehicleRun, reports_a_folder_that_cannot_be_created) {
  const io::TestFolder folder;
  folder.write("odometry", "a file where the folder should be");
  const Result<VehicleRun> run = VehicleRun::start("v1", folder.path(), nullptr);
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kMachine);
}

TEST(Degeneracy, directions_are_given_in_map_and_unknown_cells_are_empty) {
  PoseRecord pose;
  pose.t = Time::from_s(5.0);
  pose.degenerate = true;
  pose.degenerate_odom = Vec3::UnitX();
  pose.sigma_degenerate_m = std::numeric_limits<double>::infinity();
  SE3 T_map_local;
  T_map_local.R = geometry::rotation_from_rpy(0.0, 0.0, std::numbers::pi / 2.0);
  const std::string text = degeneracy_text({pose}, T_map_local, {"v1"});
  EXPECT_NE(text.find("5.000000000,1,,0.000000,1.000000,0.000000,,,,,,0.000000,lidar\n"),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace rali::drive
