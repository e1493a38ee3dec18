#include "rali/drive/fact_path.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using geometry::SE3;
using geometry::Vec3;

const VehicleId kSelf{0}, kPeer{1};

fleet::FactPtr fact(VehicleId id, std::uint32_t epoch, std::uint32_t seq, double t_s,
                    fleet::FactBody body) {
  return std::make_shared<const fleet::Fact>(
      fleet::Fact{{id, epoch, seq}, Time::from_s(t_s), std::move(body), {}});
}

fleet::Increment node(double x_m, std::optional<std::uint32_t> keyframe = {}) {
  fleet::Increment step;
  step.keyframe = keyframe;
  step.levelled = true;
  step.T_odom_body.p = {x_m, 0.0, 0.0};
  step.covariance = 1e-4 * geometry::Mat6::Identity();
  return step;
}

fleet::KeyframePoints points(std::uint32_t keyframe) {
  fleet::KeyframePoints p;
  p.keyframe = keyframe;
  p.T_body_lidar.p.z() = 0.35;
  p.points =
      fleet::PackedPoints(fleet::PointArrays{{1.0F, 2.0F}, {0.0F, 0.5F}, {0.0F, 0.5F}, {16, 208}});
  return p;
}

/// A vehicle with two starts, each of two nodes, the first of which is a keyframe.
FleetFacts two_starts() {
  const std::uint32_t later = fleet::first_keyframe_of(1);
  FleetFacts facts;
  FleetFacts::Member member;
  member.name = "v1";
  member.facts = {fact(kSelf, 0, 0, 1.0, node(0.0, 0)), fact(kSelf, 0, 1, 1.0, points(0)),
                  fact(kSelf, 0, 2, 2.0, node(1.0)),    fact(kSelf, 1, 0, 8.0, node(0.0, later)),
                  fact(kSelf, 1, 1, 9.0, node(3.0)),    fact(kSelf, 1, 2, 9.5, node(4.0))};
  facts.members = {member};
  facts.folders = {"state/v1"};
  return facts;
}

fleet::VehicleFrame frame_of(VehicleId id, std::uint32_t epoch, std::size_t group,
                             Vec3 p_m = {0, 0, 0}, double yaw_rad = 0.0) {
  fleet::VehicleFrame frame;
  frame.vehicle = id;
  frame.epoch = epoch;
  frame.group = group;
  frame.T_map_odom = {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), p_m};
  return frame;
}

TEST(KeepOneFrameEach, starts_that_are_joined_share_the_frame_of_the_first) {
  const FleetFacts facts = two_starts();
  fleet::FleetEstimate estimate;
  estimate.groups = {{kSelf, kSelf}};
  // The first start's odom is the map rotated by 90 degrees; the second one's is 5 m along y.
  estimate.frames = {frame_of(kSelf, 0, 0, {0, 0, 0}, std::numbers::pi / 2.0),
                     frame_of(kSelf, 1, 0, {0, 5, 0})};
  estimate.keyframes[{kSelf, 0}] = {};
  estimate.keyframes[{kSelf, fleet::first_keyframe_of(1)}] = {};
  FindingList findings;
  const auto frames = keep_one_frame_each(facts, estimate, findings);
  EXPECT_TRUE(findings.empty());
  EXPECT_EQ(estimate.groups, (std::vector<std::vector<VehicleId>>{{kSelf}}));
  ASSERT_EQ(estimate.frames.size(), 1U);
  EXPECT_EQ(estimate.frames[0].epoch, 0U);
  EXPECT_EQ(estimate.keyframes.size(), 2U);
  ASSERT_EQ(frames.at(0).size(), 2U);
  EXPECT_TRUE(frames[0].at(0).p.isZero());
  EXPECT_TRUE(frames[0].at(1).p.isApprox(Vec3(5.0, 0.0, 0.0), 1e-12))
      << "5 m along y of the map are 5 m along x of the turned odom";
}

TEST(KeepOneFrameEach, keeps_the_longer_of_two_unconnected_starts_and_reports_the_other) {
  const FleetFacts facts = two_starts();  // two nodes, then three
  fleet::FleetEstimate estimate;
  estimate.groups = {{kSelf}, {kSelf}};
  estimate.frames = {frame_of(kSelf, 0, 0), frame_of(kSelf, 1, 1)};
  estimate.frames[0].waits_for = "no ranges";
  estimate.keyframes[{kSelf, 0}] = {};
  FindingList findings;
  const auto frames = keep_one_frame_each(facts, estimate, findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "state.start_left_out");
  EXPECT_EQ(findings[0].text,
            "start 1 with 2 poses is not joined to the rest of its path: no ranges");
  EXPECT_EQ(estimate.groups, (std::vector<std::vector<VehicleId>>{{kSelf}}));
  EXPECT_EQ(estimate.frames.at(0).epoch, 1U);
  EXPECT_EQ(estimate.frames.at(0).group, 0U);
  EXPECT_TRUE(estimate.keyframes.empty());
  EXPECT_EQ(frames.at(0).size(), 1U);
}

TEST(KeepOneFrameEach, prefers_a_start_joined_to_other_vehicles_over_a_longer_one) {
  FleetFacts facts = two_starts();
  facts.members.push_back({"v2", true, {}, {fact(kPeer, 0, 0, 1.0, node(0.0, 0))}, 0});
  fleet::FleetEstimate estimate;
  estimate.groups = {{kSelf, kPeer}, {kSelf}};
  estimate.frames = {frame_of(kSelf, 0, 0), frame_of(kSelf, 1, 1), frame_of(kPeer, 0, 0)};
  FindingList findings;
  const auto frames = keep_one_frame_each(facts, estimate, findings);
  EXPECT_EQ(findings.size(), 1U);
  EXPECT_TRUE(frames.at(0).contains(0));
  EXPECT_FALSE(frames.at(0).contains(1));
  EXPECT_EQ(estimate.groups, (std::vector<std::vector<VehicleId>>{{kSelf, kPeer}}));
}

TEST(FactPath, gives_a_pose_at_each_node_and_keyframes_with_or_without_points) {
  const io::TestFolder folder;
  const FleetFacts facts = two_starts();
  VehicleRun run = VehicleRun::of_facts("v1", folder.path(), nullptr);
  const SE3 T_local_second{geometry::rotation_from_rpy(0.0, 0.0, std::numbers::pi / 2.0),
                           {0, 5, 0}};
  ASSERT_TRUE(fill_from_facts(facts, kSelf, {{0, SE3{}}, {1, T_local_second}}, run));
  ASSERT_EQ(run.poses().size(), 5U);
  EXPECT_TRUE(run.poses()[1].T_local_body.p.isApprox(Vec3(1.0, 0.0, 0.0), 1e-12));
  // 3 m ahead in the second start's odom, which heads along y.
  EXPECT_TRUE(run.poses()[3].T_local_body.p.isApprox(Vec3(0.0, 8.0, 0.0), 1e-12));
  ASSERT_EQ(run.keyframes().size(), 2U);
  EXPECT_EQ(run.keyframes()[0].points, 2U);
  EXPECT_FALSE(run.keyframes()[0].has_rings);
  EXPECT_EQ(run.keyframes()[1].points, 0U) << "nobody kept them";
  EXPECT_EQ(run.keyframes()[1].T_body_lidar.p.z(), 0.35) << "that of the other keyframes";
  ASSERT_TRUE(run.finish());
  EXPECT_TRUE(run.knows_gravity());
  EXPECT_TRUE(std::isnan(run.tilt_sigma_rad())) << "facts do not say how well";

  const std::string out = folder.path();
  std::size_t seen = 0;
  ASSERT_TRUE(keyframe_stream(out, run.keyframes(), {})([&](const map::KeyframeView& view) {
    EXPECT_TRUE(view.ring.empty());
    if (seen++ > 0) return;
    ASSERT_EQ(view.intensity.size(), 2U);
    EXPECT_EQ(view.intensity[1], 208.0F);
  }));
  EXPECT_EQ(seen, 2U);
}

TEST(FactPath, a_start_without_a_frame_is_left_out) {
  const io::TestFolder folder;
  VehicleRun run = VehicleRun::of_facts("v1", folder.path(), nullptr);
  ASSERT_TRUE(fill_from_facts(two_starts(), kSelf, {{1, SE3{}}}, run));
  EXPECT_EQ(run.poses().size(), 3U);
  EXPECT_EQ(run.keyframes().size(), 1U);
}

TEST(FactPath, a_degenerate_node_is_constrained_by_ranges_reported_shortly_before) {
  const io::TestFolder folder;
  fleet::Increment degenerate = node(1.0);
  degenerate.degenerate = true;
  degenerate.lidar_information.diagonal() << 1.0, 1.0, 1.0, 0.0, 9.0, 9.0;  // unobservable along x
  fleet::RangeBlock block;
  block.ranges.resize(1);
  block.ranges[0].t = Time::from_s(1.9);
  block.ranges[0].from = kSelf;
  block.ranges[0].to = kPeer;
  FleetFacts facts = two_starts();
  facts.members[0].facts = {fact(kSelf, 0, 0, 1.0, node(0.0, 0)),
                            fact(kSelf, 0, 1, 2.0, degenerate), fact(kSelf, 0, 2, 9.0, degenerate),
                            fact(kSelf, 0, 3, 2.0, block)};
  VehicleRun run = VehicleRun::of_facts("v1", folder.path(), nullptr);
  ASSERT_TRUE(fill_from_facts(facts, kSelf, {{0, SE3{}}}, run));
  ASSERT_EQ(run.poses().size(), 3U);
  EXPECT_EQ(run.poses()[1].range_from, kPeer);
  EXPECT_EQ(run.poses()[1].held_by, HeldBy::kRange);
  EXPECT_NEAR(std::abs(run.poses()[1].degenerate_odom.x()), 1.0, 1e-12);
  EXPECT_EQ(run.poses()[2].held_by, HeldBy::kNothing) << "no range for 7 s";
}

TEST(FactPathSource, reports_what_the_facts_hold) {
  FleetFacts facts = two_starts();
  facts.members[0].missing = 2;
  const auto source = fact_source(facts, 0);
  const InputReport& report = source->report();
  EXPECT_EQ(report.vehicle, "v1");
  EXPECT_EQ(report.scans, 5U);
  EXPECT_EQ(report.t_start, Time::from_s(1.0));
  EXPECT_EQ(report.t_end, Time::from_s(9.5));
  EXPECT_EQ(report.T_body_lidar.p.z(), 0.35);
  EXPECT_TRUE(report.has_imu);
  EXPECT_TRUE(report.gaps.damaged);
  EXPECT_EQ(missing_findings(facts).at(0).text, "2 of 8 facts are in no folder");
}

}  // namespace
}  // namespace rali::drive
