#include "rali/fleet/centre/frame_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "rali/fleet/centre/path_frames.hpp"
#include "rali/places/world_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::SE3;
using geometry::Vec3;
namespace world = places::test;

/// 60 m along x with objects of all sizes on both sides of a free lane.
world::World lane(std::uint64_t seed) {
  world::World w;
  world::add_shell(w, {0.0, -6.0, 0.0}, {60.0, 6.0, 4.0});
  Rng rng(seed, "lane");
  for (double x = 1.0; x < 59.0; x += 1.5) {
    const double side = rng.below(2) == 0 ? 1.0 : -1.0;
    const Vec3 middle(x + rng.uniform(-0.5, 0.5), side * rng.uniform(2.5, 5.5), 0.0);
    const Vec3 half(rng.uniform(0.2, 0.6), rng.uniform(0.2, 0.6), 0.0);
    w.push_back({middle - half, middle + half + Vec3(0.0, 0.0, rng.uniform(0.5, 3.5))});
  }
  return w;
}

/// The path of a vehicle along x through a world, in an odom frame of its own.
VehiclePath driven(const world::World& w, std::uint16_t vehicle, double from_x_m, double to_x_m,
                   const SE3& T_odom_world) {
  VehiclePath path(VehicleId{vehicle});
  Rng rng(vehicle, "sweeps");
  const double sign = to_x_m > from_x_m ? 1.0 : -1.0;
  const world::Sensor sensor;
  for (std::uint32_t k = 0; k <= static_cast<std::uint32_t>(std::abs(to_x_m - from_x_m)); ++k) {
    const world::Scan scan =
        world::look(w, world::at(from_x_m + sign * k, 0.0, sign > 0.0 ? 0.0 : 180.0), rng, sensor);
    KeyframePoints points;
    points.keyframe = k;
    points.T_body_lidar.p.z() = sensor.height_m;
    points.points = PackedPoints(PointArrays{scan.x_m, scan.y_m, scan.z_m, {}});
    Increment step;
    step.node = k;
    step.keyframe = k;
    step.begins = k == 0;
    step.T_odom_body = T_odom_world * scan.T_world_body;
    // 1 cm and 0.03 deg for each 10 m.
    step.covariance.diagonal().setConstant(k * 1e-5);
    step.covariance.diagonal().head<3>().setConstant(k * 2.5e-8);
    path.add(Time::from_s(k), step);
    path.add(Time::from_s(k), points);
  }
  return path;
}

PathFrames found(const std::vector<VehiclePath>& paths, const JointRanges& ranges = {},
                 const std::vector<StartPrior>& starts = {}, const FleetSettings& settings = {}) {
  SerialExecutor executor;
  const auto submaps = cut_into_submaps(paths, settings.cut, settings.places, executor);
  return frames_of(paths,
                   find_frames(paths, submaps, ranges, starts, settings, executor).solver.frames());
}

/// Start of the second path relative to that of the first: 52 m ahead, rotated by half a turn.
StartPrior start_of_second() {
  StartPrior start;
  start.path = 1;
  start.T_relative_path = world::at(52.0, 0.0, 180.0);
  start.sigma_m = 0.3;
  start.sigma_rad = 0.02;
  return start;
}

/// Between antennas 2.8 m up, at all times covered by both paths. They are too long, alternately by
/// 0.1 m and 0.7 m.
JointRanges late_ranges(const std::vector<VehiclePath>& paths, const SE3& T_odom1_world,
                        const SE3& T_odom2_world) {
  JointRanges joint;
  joint.pairs = {{{0, 0}, {1, 0}}};
  const std::size_t n = std::min(paths[0].nodes().size(), paths[1].nodes().size());
  for (std::size_t k = 0; k < n; ++k) {
    JointRange r;
    r.t = paths[0].nodes()[k].t;
    const auto end = [&](std::size_t path) {
      RangeEnd e;
      e.place = *paths[path].at(r.t);
      e.p_odom_m = e.place.T_odom_body * Vec3(0.0, 0.0, 2.8);
      return e;
    };
    r.a = end(0);
    r.b = end(1);
    const Vec3 p = T_odom1_world.inverse() * r.a.p_odom_m;
    const Vec3 q = T_odom2_world.inverse() * r.b.p_odom_m;
    r.range_m = (p - q).norm() + (k % 2 == 0 ? 0.1 : 0.7);
    r.sigma_m = 0.1;
    joint.ranges.push_back(r);
  }
  return joint;
}

StartPrior start_ahead(std::size_t relative_to, std::size_t path, double x_m) {
  StartPrior start;
  start.relative_to = relative_to;
  start.path = path;
  start.T_relative_path = world::at(x_m, 0.0, 0.0);
  return start;
}

// Without ranges, start poses or a common clock: two recordings of different days.
TEST(FrameSearch, joins_two_paths_by_place_recognition_alone) {
  const world::World w = lane(7);
  const SE3 T_odom2_world(geometry::rotation_from_rpy(0.0, 0.0, 0.7), Vec3(5.0, -3.0, 0.1));
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, world::at(-4.0, 0.0, 0.0)),
                                          driven(w, 1, 56.0, 12.0, T_odom2_world)};
  const PathFrames frames = found(paths);
  ASSERT_EQ(frames.groups.size(), 1U);
  EXPECT_EQ(frames.decided_by[1], DecidedBy::kScans);
  // Start of the second path relative to that of the first: 52 m ahead, rotated by half a turn.
  const SE3 T = frames.T_map_odom[1] * paths[1].nodes().front().step->T_odom_body;
  EXPECT_NEAR((T.p - Vec3(52.0, 0.0, 0.0)).norm(), 0.0, 0.1);
  EXPECT_NEAR(std::abs(places::yaw_of(T.R)), std::acos(-1.0), 0.005);
}

// The third is connected only to the second. Its count of evaluations restarts when the second
// joins the first, and no new data follows.
TEST(FrameSearch, joins_a_third_path_by_a_chain_of_start_poses) {
  const world::World w = lane(7);
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 20.0, world::at(-4.0, 0.0, 0.0)),
                                          driven(w, 1, 14.0, 34.0, world::at(-14.0, 0.0, 0.0)),
                                          driven(w, 2, 28.0, 44.0, world::at(-28.0, 0.0, 0.0))};
  const std::vector<StartPrior> starts = {start_ahead(0, 1, 10.0), start_ahead(1, 2, 14.0)};
  FleetSettings settings;
  settings.loops.degenerate_tries = 3;
  const PathFrames frames = found(paths, {}, starts, settings);
  ASSERT_EQ(frames.groups.size(), 1U);
  EXPECT_NEAR(frames.T_map_odom[2].p.x(), 24.0, 0.1);
}

// Start poses of two vehicles relative to the first also predict their common places: no search for
// similar places is needed.
TEST(FrameSearch, predicts_loop_candidates_between_two_paths_with_start_poses_from_a_third) {
  const world::World w = lane(7);
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 30.0, world::at(-4.0, 0.0, 0.0)),
                                          driven(w, 1, 10.0, 36.0, world::at(-10.0, 0.0, 0.0)),
                                          driven(w, 2, 14.0, 40.0, world::at(-14.0, 0.0, 0.0))};
  const std::vector<StartPrior> starts = {start_ahead(0, 1, 6.0), start_ahead(0, 2, 10.0)};
  SerialExecutor executor;
  const FleetSettings settings;
  const auto submaps = cut_into_submaps(paths, settings.cut, settings.places, executor);
  const FoundFrames frames = find_frames(paths, submaps, {}, starts, settings, executor);
  EXPECT_EQ(frames.solver.frames().groups.size(), 1U);
  EXPECT_TRUE(std::any_of(frames.seen.begin(), frames.seen.end(), [&](const LoopFound& f) {
    return submaps[f.candidate.target].path == 1 && submaps[f.candidate.source].path == 2;
  }));
  for (const LoopFound& f : frames.seen) EXPECT_TRUE(f.candidate.guess.has_value());
}

// There is a wall above the opening that both have driven through: their radios range through it.
TEST(FrameSearch, joins_paths_by_scans_despite_contradicting_ranges_through_walls) {
  world::World w = lane(7);
  w.push_back({{29.9, -6.0, 0.0}, {30.1, -1.2, 4.0}});
  w.push_back({{29.9, 1.2, 0.0}, {30.1, 6.0, 4.0}});
  w.push_back({{29.9, -1.2, 2.0}, {30.1, 1.2, 4.0}});
  const SE3 T_odom1_world = world::at(-4.0, 0.0, 0.0);
  const SE3 T_odom2_world(geometry::rotation_from_rpy(0.0, 0.0, 0.7), Vec3(5.0, -3.0, 0.1));
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, T_odom1_world),
                                          driven(w, 1, 56.0, 12.0, T_odom2_world)};
  const JointRanges ranges = late_ranges(paths, T_odom1_world, T_odom2_world);
  FleetSettings settings;
  settings.loops.degenerate_tries = 16;  // the first of them are close together
  FleetSettings without_walls = settings;
  without_walls.joint.sight = false;
  EXPECT_EQ(found(paths, ranges, {}, without_walls).groups.size(), 2U) << "else this tests nothing";

  const PathFrames frames = found(paths, ranges, {}, settings);
  ASSERT_EQ(frames.groups.size(), 1U);
  const SE3 T = frames.T_map_odom[1] * paths[1].nodes().front().step->T_odom_body;
  EXPECT_NEAR((T.p - Vec3(52.0, 0.0, 0.0)).norm(), 0.0, 0.2);
}

// Ranges that contradict in free air are no walls: it is undecided which source is right.
TEST(FrameSearch, does_not_join_paths_whose_line_of_sight_ranges_contradict_the_scans) {
  const world::World w = lane(7);
  const SE3 T_odom1_world = world::at(-4.0, 0.0, 0.0);
  const SE3 T_odom2_world(geometry::rotation_from_rpy(0.0, 0.0, 0.7), Vec3(5.0, -3.0, 0.1));
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, T_odom1_world),
                                          driven(w, 1, 56.0, 12.0, T_odom2_world)};
  const JointRanges ranges = late_ranges(paths, T_odom1_world, T_odom2_world);
  FleetSettings settings;
  settings.loops.degenerate_tries = 16;
  EXPECT_EQ(found(paths, ranges, {}, settings).groups.size(), 2U);
}

// A measured start pose connects two vehicles at once; ranges that contradict it and the scans
// alike are wrong themselves.
TEST(FrameSearch, keeps_a_start_pose_confirmed_by_scans_against_contradicting_ranges) {
  const world::World w = lane(7);
  const SE3 T_odom1_world = world::at(-4.0, 0.0, 0.0);
  const SE3 T_odom2_world(geometry::rotation_from_rpy(0.0, 0.0, 0.7), Vec3(5.0, -3.0, 0.1));
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, T_odom1_world),
                                          driven(w, 1, 56.0, 12.0, T_odom2_world)};
  const JointRanges ranges = late_ranges(paths, T_odom1_world, T_odom2_world);
  const PathFrames frames = found(paths, ranges, {start_of_second()}, FleetSettings{});
  ASSERT_EQ(frames.groups.size(), 1U);
  const SE3 T = frames.T_map_odom[1] * paths[1].nodes().front().step->T_odom_body;
  EXPECT_NEAR((T.p - Vec3(52.0, 0.0, 0.0)).norm(), 0.0, 0.5);
}

FoundFrames searched(const std::vector<VehiclePath>& paths, const std::vector<StartPrior>& starts) {
  SerialExecutor executor;
  const FleetSettings settings;
  const auto submaps = cut_into_submaps(paths, settings.cut, settings.places, executor);
  return find_frames(paths, submaps, {}, starts, settings, executor);
}

// Measured from the wrong side of the vehicle: no scan fits, and the rays of each pass through
// walls of the other.
TEST(FrameSearch, rejects_a_start_pose_that_scans_contradict_and_joins_by_place_recognition) {
  const world::World w = lane(7);
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, world::at(-4.0, 0.0, 0.0)),
                                          driven(w, 1, 56.0, 12.0, world::at(5.0, -3.0, 40.0))};
  StartPrior wrong = start_of_second();
  wrong.T_relative_path = world::at(28.0, 1.0, 100.0);
  const FoundFrames out = searched(paths, {wrong});
  ASSERT_EQ(out.contradicted.size(), 1U);
  EXPECT_EQ(out.contradicted[0].path, 1U);
  EXPECT_GE(out.contradicted[0].comparisons, 3);
  const PathFrames frames = frames_of(paths, out.solver.frames());
  ASSERT_EQ(frames.groups.size(), 1U);
  const SE3 T = frames.T_map_odom[1] * paths[1].nodes().front().step->T_odom_body;
  EXPECT_NEAR((T.p - Vec3(52.0, 0.0, 0.0)).norm(), 0.0, 0.1);
}

TEST(FrameSearch, reports_no_contradiction_for_a_correct_start_pose) {
  const world::World w = lane(7);
  const std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, world::at(-4.0, 0.0, 0.0)),
                                          driven(w, 1, 56.0, 12.0, world::at(5.0, -3.0, 40.0))};
  EXPECT_TRUE(searched(paths, {start_of_second()}).contradicted.empty());
  // Two parts of a corridor without overlap: nothing confirms the start pose, nothing contradicts
  // it.
  const world::World c = world::corridor({});
  const std::vector<VehiclePath> apart = {driven(c, 0, -45.0, -15.0, SE3{}),
                                          driven(c, 1, 5.0, 35.0, world::at(7.0, 1.0, 20.0))};
  StartPrior start;
  start.path = 1;
  start.T_relative_path = world::at(50.0, 0.0, 0.0);
  const FoundFrames out = searched(apart, {start});
  EXPECT_TRUE(out.contradicted.empty());
  EXPECT_EQ(frames_of(apart, out.solver.frames()).groups.size(), 1U);
}

// Every door looks like the next one: the similar place is 50 m away.
TEST(FrameSearch, does_not_join_two_similar_parts_of_a_corridor) {
  const world::World w = world::corridor({});
  const std::vector<VehiclePath> paths = {driven(w, 0, -45.0, -15.0, SE3{}),
                                          driven(w, 1, 5.0, 35.0, world::at(7.0, 1.0, 20.0))};
  EXPECT_EQ(found(paths).groups.size(), 2U);
}

/// Two vehicles that meet in a lane, and the results of comparing their pieces so far.
struct Meeting {
  world::World w = lane(7);
  std::vector<VehiclePath> paths = {driven(w, 0, 4.0, 40.0, world::at(-4.0, 0.0, 0.0)),
                                    driven(w, 1, 56.0, 12.0, world::at(5.0, -3.0, 40.0))};
  ComparedPieces compared;

  PathFrames solve() {
    SerialExecutor executor;
    FleetSettings settings;
    settings.loops.scans_only_tries = 6;
    const auto submaps = cut_into_submaps(paths, settings.cut, settings.places, executor);
    return frames_of(
        paths, find_frames(paths, submaps, {}, {}, settings, executor, &compared).solver.frames());
  }
};

TEST(ComparedPieces, are_registered_once_and_reused_in_later_solutions) {
  Meeting meeting;
  const PathFrames first = meeting.solve();
  const std::size_t made = meeting.compared.made();
  EXPECT_GT(made, 3U);
  const PathFrames again = meeting.solve();
  EXPECT_EQ(meeting.compared.made(), made);
  ASSERT_EQ(first.groups.size(), 1U);
  ASSERT_EQ(again.groups.size(), 1U);
  EXPECT_LT(geometry::boxminus(first.T_map_odom[1], again.T_map_odom[1]).norm(), 1e-9);
  // It drives on: the last pieces are new and look different.
  meeting.paths[1] = driven(meeting.w, 1, 56.0, 6.0, world::at(5.0, -3.0, 40.0));
  EXPECT_EQ(meeting.solve().groups.size(), 1U);
  EXPECT_GT(meeting.compared.made(), made);
  EXPECT_LE(meeting.compared.made(), 2 * made);
}

TEST(ComparedPieces, are_reused_after_a_tilt_of_1_mrad_but_not_10_mrad) {
  Meeting meeting;
  const PathFrames first = meeting.solve();
  const std::size_t made = meeting.compared.made();
  meeting.paths[1].set_up_odom(geometry::rotation_from_rpy(0.001, 0.0, 0.0) * Vec3::UnitZ());
  const PathFrames tilted = meeting.solve();
  EXPECT_LE(meeting.compared.made(), made + 2) << "few pairs look alike that did not before";
  ASSERT_EQ(tilted.groups.size(), 1U);
  EXPECT_LT((first.T_map_odom[1].p - tilted.T_map_odom[1].p).norm(), 0.1);
  meeting.paths[1].set_up_odom(geometry::rotation_from_rpy(0.01, 0.0, 0.0) * Vec3::UnitZ());
  static_cast<void>(meeting.solve());
  EXPECT_GT(meeting.compared.made(), made + 3) << "half a degree: compared again";
}

}  // namespace
}  // namespace rali::fleet
