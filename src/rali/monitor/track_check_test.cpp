#include "rali/monitor/track_check.hpp"

#include <gtest/gtest.h>

namespace rali::monitor {
namespace {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

/// 60 s along x at 1 m/s, a pose each half second.
std::vector<StatedPose> straight(double sigma_m) {
  std::vector<StatedPose> track;
  for (int i = 0; i <= 120; ++i) {
    StatedPose pose;
    pose.t = Time::from_s(100.0 + 0.5 * i);
    pose.T.p = Vec3(0.5 * i, 0.0, 0.0);
    pose.position_covariance = sigma_m * sigma_m * Mat3::Identity();
    track.push_back(pose);
  }
  return track;
}

TEST(TrackCheck, equal_tracks_give_no_contradiction) {
  const auto track = straight(0.01);
  EXPECT_TRUE(check_track(track, track, {}, {}).empty());
}

TEST(TrackCheck, reports_interval_distance_and_stated_sigma) {
  const auto reference = straight(0.01);
  auto judged = straight(0.05);
  for (std::size_t i = 40; i <= 60; ++i) judged[i].T.p.y() = 0.6;
  const auto found = check_track(judged, reference, {}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(seconds_between(Time::from_s(100.0), found[0].when.begin), 20.0, 1e-6);
  EXPECT_NEAR(seconds_between(Time::from_s(100.0), found[0].when.end), 30.0, 1e-6);
  EXPECT_NEAR(found[0].off_m, 0.6, 1e-9);
  EXPECT_NEAR(found[0].stated_m, 0.05, 1e-9);
}

TEST(TrackCheck, deviation_within_the_stated_uncertainty_is_no_contradiction) {
  const auto reference = straight(0.01);
  auto judged = straight(0.25);
  for (auto& pose : judged) pose.T.p.y() = 0.6;
  EXPECT_TRUE(check_track(judged, reference, {}, {}).empty());
}

TEST(TrackCheck, an_uncertain_reference_gives_no_contradiction) {
  const auto reference = straight(2.0);
  auto judged = straight(0.05);
  for (auto& pose : judged) pose.T.p.x() += 1.5;
  EXPECT_TRUE(check_track(judged, reference, {}, {}).empty());
}

TEST(TrackCheck, only_uncertainty_in_the_direction_of_the_deviation_counts) {
  const auto reference = straight(0.01);
  auto judged = straight(0.02);
  for (auto& pose : judged) {
    pose.T.p.y() = 0.5;
    pose.position_covariance(0, 0) = 100.0;  // along the tunnel
  }
  EXPECT_EQ(check_track(judged, reference, {}, {}).size(), 1U);
  for (auto& pose : judged) pose.position_covariance(1, 1) = 100.0;
  EXPECT_TRUE(check_track(judged, reference, {}, {}).empty());
}

TEST(TrackCheck, frames_are_aligned_at_the_first_common_pose) {
  const auto reference = straight(0.01);
  auto judged = straight(0.01);
  SE3 T;
  T.R = geometry::so3_exp(Vec3(0.0, 0.0, 1.0));
  T.p = Vec3(3.0, -2.0, 0.5);
  for (auto& pose : judged) pose.T = T * pose.T;
  judged.erase(judged.begin(), judged.begin() + 10);
  const SE3 T_reference_judged = agreeing_at_first(judged, reference);
  EXPECT_TRUE(check_track(judged, reference, T_reference_judged, {}).empty());
  EXPECT_FALSE(check_track(judged, reference, {}, {}).empty());
}

TEST(TrackCheck, a_nan_pose_is_a_contradiction) {
  const auto reference = straight(0.01);
  auto judged = straight(0.01);
  for (std::size_t i = 10; i < 20; ++i) judged[i].T.p.x() = std::nan("");
  EXPECT_EQ(check_track(judged, reference, {}, {}).size(), 1U);
}

TEST(TrackCheck, gaps_of_the_reference_are_not_checked) {
  auto reference = straight(0.01);
  reference.erase(reference.begin() + 20, reference.begin() + 80);
  auto judged = straight(0.01);
  for (std::size_t i = 22; i < 78; ++i) judged[i].T.p.y() = 5.0;
  EXPECT_TRUE(check_track(judged, reference, {}, {}).empty());
}

TEST(TrackCheck, a_long_contradiction_is_given_in_parts_with_their_own_figures) {
  const auto reference = straight(0.01);
  auto judged = straight(0.01);
  for (std::size_t i = 20; i < judged.size(); ++i) {
    judged[i].T.p.y() = 0.1 * static_cast<double>(i - 15);
  }
  MonitorSettings settings;
  settings.part_max_s = 0.25 * seconds_between(judged[20].t, judged.back().t);
  const auto parts = check_track(judged, reference, {}, settings);
  ASSERT_GE(parts.size(), 4U);
  EXPECT_EQ(parts.front().when.begin, judged[20].t);
  EXPECT_EQ(parts.back().when.end, judged.back().t);
  for (std::size_t k = 1; k < parts.size(); ++k) {
    EXPECT_EQ(parts[k].when.begin, parts[k - 1].when.end);
    EXPECT_GT(parts[k].off_m, parts[k - 1].off_m);
  }
}

}  // namespace
}  // namespace rali::monitor
