#include "rali/fleet/centre/group_estimate.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/fleet/centre/pieces_for_test.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec3;

/// The frames place the second vehicle 3 m to the left of the first one. Comparisons are of pieces
/// around keyframes 2 and 8 of both, and 5 of a third that is in no group with them.
FleetEstimate estimate(const std::vector<StartPrior>& starts,
                       const std::vector<LoopFound>& seen = {}, LoopMemory* memory = nullptr) {
  const std::vector<VehiclePath> paths = {straight_path(1), straight_path(2), straight_path(3)};
  const std::vector<PathSubmap> pieces = {piece_of(paths[0], 0, 2), piece_of(paths[0], 0, 8),
                                          piece_of(paths[1], 1, 2), piece_of(paths[1], 1, 8),
                                          piece_of(paths[2], 2, 5)};
  PathFrames frames;
  frames.groups = {{0, 1}, {2}};
  frames.group = {0, 0, 1};
  frames.T_map_odom.resize(3);
  frames.T_map_odom[1].p = {0.0, 3.0, 0.0};
  frames.decided_by = {std::nullopt, DecidedBy::kRangesAndScans, std::nullopt};
  const JointRanges ranges;
  FleetSettings settings;
  settings.loops.passes = 1;
  settings.places.near.view_m = 0.1;  // nothing is compared: the matches are given
  settings.places.near.gate = 0.0;
  SerialExecutor executor;
  FleetEstimate out;
  std::vector<Loop> loops;
  for (const LoopFound& found : seen) {
    loops.push_back(loop_of(pieces, found, settings.loops.bend_per_m));
  }
  GroupInput in{paths, pieces, frames, ranges, starts, {}, settings, loops};
  in.memory = memory;
  estimate_group(in, 0, executor, out);
  return out;
}

StartPrior start(double x_m, double y_m) {
  StartPrior s;
  s.path = 1;
  s.T_relative_path.p = {x_m, y_m, 0.0};
  return s;
}

TEST(GroupEstimate, uses_a_consistent_start_pose) {
  const FleetEstimate e = estimate({start(0.1, 3.1)});
  EXPECT_TRUE(e.rejected_starts.empty());
  EXPECT_NEAR(e.frames[1].T_map_odom.p.x(), 0.1, 1e-3);
  EXPECT_NEAR(e.frames[1].T_map_odom.p.y(), 3.1, 1e-3);
}

// With two start poses 10 m apart, the vehicle was placed in the middle, with a sigma of 0.1 m.
TEST(GroupEstimate, rejects_a_start_pose_10_m_off_without_shifting_the_frames) {
  const FleetEstimate e = estimate({start(0.1, 3.1), start(10.0, 3.0)});
  EXPECT_NEAR(e.frames[1].T_map_odom.p.x(), 0.1, 1e-3);
  EXPECT_NEAR(e.frames[1].T_map_odom.p.y(), 3.1, 1e-3);
  ASSERT_EQ(e.rejected_starts.size(), 1U);
  EXPECT_EQ(e.rejected_starts[0].vehicle, VehicleId{2});
  EXPECT_EQ(e.rejected_starts[0].relative_to, VehicleId{1});
  EXPECT_NEAR(e.rejected_starts[0].off_m, std::hypot(9.9, 0.1), 1e-3) << "of the solution";
}

TEST(GroupEstimate, confirms_a_start_pose_that_loops_agree_with_and_the_frame_search_did_not) {
  const FleetEstimate e = estimate({start(-2.0, 3.0)}, {seen_at({-2.05, 3.0, 0.0}, 0, 2, 0.01)});
  EXPECT_TRUE(e.rejected_starts.empty());
  EXPECT_NEAR(e.frames[1].T_map_odom.p.x(), -2.05, 0.02);
}

TEST(GroupEstimate, rejects_a_start_pose_whose_heading_is_1_rad_off) {
  StartPrior turned = start(0.0, 3.0);
  turned.T_relative_path.R = geometry::rotation_from_rpy(0.0, 0.0, 1.0);
  const FleetEstimate e = estimate({start(0.0, 3.0), turned});
  ASSERT_EQ(e.rejected_starts.size(), 1U);
  EXPECT_NEAR(e.rejected_starts[0].off_rad, 1.0, 1e-9);
}

// Two recordings connected by places alone: without the loops that joined them the graph would have
// no constraint between them, and no guess for further loops.
TEST(GroupEstimate, adds_the_match_that_joined_the_frames_as_a_loop_closure) {
  const FleetEstimate e = estimate({}, {seen_at({0.0, 3.1, 0.0}, 0, 2, 0.01)});
  ASSERT_EQ(e.loops.size(), 1U);
  EXPECT_TRUE(e.loops[0].accepted) << e.loops[0].reason;
  EXPECT_EQ(e.loops[0].from, (KeyframeId{VehicleId{1}, 2}));
  EXPECT_EQ(e.loops[0].to, (KeyframeId{VehicleId{2}, 2}));
  EXPECT_NEAR(e.frames[1].T_map_odom.p.y(), 3.1, 2e-3);
}

TEST(GroupEstimate, ignores_matches_with_paths_outside_this_group) {
  const FleetEstimate e = estimate({}, {seen_at({0.0, 0.0, 0.0}, 4, 4, 0.01)});
  EXPECT_TRUE(e.loops.empty());
  EXPECT_NEAR(e.frames[1].T_map_odom.p.y(), 3.0, 1e-6);
}

// The result of an earlier comparison counts once.
TEST(GroupEstimate, keeps_a_remembered_loop_closure_instead_of_a_new_match) {
  LoopMemory memory;
  static_cast<void>(estimate({}, {seen_at({0.0, 3.1, 0.0}, 0, 2, 0.01)}, &memory));
  ASSERT_EQ(memory.loops.size(), 1U);
  const FleetEstimate e = estimate({}, {seen_at({0.0, 3.3, 0.0}, 0, 2, 0.01)}, &memory);
  ASSERT_EQ(memory.loops.size(), 1U);
  EXPECT_NEAR(e.frames[1].T_map_odom.p.y(), 3.1, 2e-3);
}

}  // namespace
}  // namespace rali::fleet
