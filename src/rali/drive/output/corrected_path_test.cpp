#include "rali/drive/output/corrected_path.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

using geometry::SE3;
using geometry::Vec3;

PoseRecord pose_at(double t_s, double x_m) {
  PoseRecord pose;
  pose.t = Time::from_s(t_s);
  pose.T_local_body.p = {x_m, 0.0, 0.0};
  pose.covariance = 0.01 * geometry::Mat6::Identity();
  return pose;
}

KeyframeRecord keyframe_at(std::uint32_t seq, double t_s, double x_m) {
  KeyframeRecord keyframe;
  keyframe.id.seq = seq;
  keyframe.t = Time::from_s(t_s);
  keyframe.T_local_body.p = {x_m, 0.0, 0.0};
  keyframe.covariance = 0.01 * geometry::Mat6::Identity();
  return keyframe;
}

vehicle::KeyframeCorrected corrected(double x_m, double y_m, double yaw_rad, double variance) {
  vehicle::KeyframeCorrected reported;
  reported.T_local_body.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
  reported.T_local_body.p = {x_m, y_m, 0.0};
  reported.covariance = variance * geometry::Mat6::Identity();
  return reported;
}

TEST(CorrectedPath, is_bit_identical_without_corrections) {
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.1), pose_at(1.0, 1.0 / 3.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.1)};
  correct_path({}, poses, keyframes);
  EXPECT_EQ(poses[1].T_local_body.p.x(), 1.0 / 3.0);
  EXPECT_EQ(keyframes[0].T_local_body.p.x(), 0.1);
}

TEST(CorrectedPath, interpolates_corrections_by_distance_travelled_between_keyframes) {
  // 4 m between the keyframes, the second one moved by 0.4 m: after 1 m it is 0.1 m.
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.0), pose_at(3.0, 1.0), pose_at(4.0, 4.0),
                                   pose_at(5.0, 5.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.0), keyframe_at(1, 4.0, 4.0)};
  correct_path({{0, corrected(0.0, 0.0, 0.0, 0.02)}, {1, corrected(4.4, 0.0, 0.0, 0.06)}}, poses,
               keyframes);
  EXPECT_NEAR(poses[0].T_local_body.p.x(), 0.0, 1e-12);
  EXPECT_NEAR(poses[1].T_local_body.p.x(), 1.1, 1e-12) << "by the way, not by the time";
  EXPECT_NEAR(poses[2].T_local_body.p.x(), 4.4, 1e-12);
  EXPECT_NEAR(poses[3].T_local_body.p.x(), 5.4, 1e-12) << "constant after the last";
  EXPECT_NEAR(poses[1].covariance(5, 5), 0.03, 1e-12);
  EXPECT_NEAR(poses[2].covariance(5, 5), 0.06, 1e-12);
  EXPECT_NEAR(poses[3].covariance(5, 5), 0.06, 1e-12) << "after the last it is known no better";
  EXPECT_NEAR(keyframes[1].T_local_body.p.x(), 4.4, 1e-12);
  EXPECT_NEAR(keyframes[1].covariance(0, 0), 0.06, 1e-12);
}

// A vehicle at standstill for ten minutes after its last keyframe was 3 cm off with a stated sigma
// of 1.3 cm: the odometry's, which excludes the error of the frame between the vehicles.
TEST(CorrectedPath, covariance_after_the_last_keyframe_grows_with_the_odometry) {
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.0), pose_at(1.0, 1.0), pose_at(2.0, 2.0)};
  poses[1].covariance(3, 3) += 0.09;  // degenerate along x
  poses[2].covariance *= 0.5;         // ranges came
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.0)};
  correct_path({{0, corrected(0.0, 0.0, 0.0, 0.04)}}, poses, keyframes);
  EXPECT_NEAR(poses[0].covariance(3, 3), 0.04, 1e-12);
  EXPECT_NEAR(poses[1].covariance(3, 3), 0.13, 1e-12);
  EXPECT_NEAR(poses[1].covariance(4, 4), 0.04, 1e-12);
  EXPECT_NEAR(poses[2].covariance(3, 3), 0.04, 1e-12) << "of the way since, not of the keyframe";
}

TEST(CorrectedPath, does_not_shift_poses_at_standstill) {
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.0), pose_at(60.0, 0.0), pose_at(61.0, 1.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.0), keyframe_at(1, 61.0, 1.0)};
  correct_path({{1, corrected(1.5, 0.0, 0.0, 0.01)}}, poses, keyframes);
  EXPECT_NEAR(poses[1].T_local_body.p.x(), 0.0, 1e-12) << "one minute later it still stands there";
  EXPECT_NEAR(poses[2].T_local_body.p.x(), 1.5, 1e-12);
}

TEST(CorrectedPath, rotates_later_poses_about_a_rotated_keyframe) {
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.0), pose_at(1.0, 2.0), pose_at(2.0, 3.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.0), keyframe_at(1, 1.0, 2.0)};
  correct_path({{1, corrected(2.0, 0.0, std::numbers::pi / 2.0, 0.01)}}, poses, keyframes);
  EXPECT_TRUE(poses[2].T_local_body.p.isApprox(Vec3(2.0, 1.0, 0.0), 1e-12))
      << poses[2].T_local_body.p.transpose();
}

TEST(CorrectedPath, shifts_poses_before_the_first_keyframe_with_it) {
  std::vector<PoseRecord> poses = {pose_at(0.0, -1.0), pose_at(1.0, 0.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(3, 1.0, 0.0)};
  correct_path({{3, corrected(0.2, 0.0, 0.0, 0.01)}}, poses, keyframes);
  EXPECT_NEAR(poses[0].T_local_body.p.x(), -0.8, 1e-12);
}

TEST(CorrectedPath, ignores_corrections_of_diverged_or_unknown_keyframes) {
  std::vector<PoseRecord> poses = {pose_at(0.0, 0.0), pose_at(1.0, 1.0)};
  std::vector<KeyframeRecord> keyframes = {keyframe_at(0, 0.0, 0.0), keyframe_at(1, 1.0, 1.0)};
  keyframes[1].diverged = true;
  correct_path({{1, corrected(9.0, 0.0, 0.0, 1.0)}, {77, corrected(9.0, 0.0, 0.0, 1.0)}}, poses,
               keyframes);
  EXPECT_EQ(poses[1].T_local_body.p.x(), 1.0);
  EXPECT_EQ(keyframes[1].T_local_body.p.x(), 1.0);
  std::vector<PoseRecord> none;
  std::vector<KeyframeRecord> no_keyframes;
  correct_path({{1, corrected(9.0, 0.0, 0.0, 1.0)}}, none, no_keyframes);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace rali::drive
