#include "rali/fleet/centre/sight_lines.hpp"

#include <gtest/gtest.h>

#include "rali/places/world_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec3;
using places::test::at;

/// Two rooms of 6 m by 6 m, a wall 0.2 m thick between them at x = 6, a door in it at y = 5.
places::test::World two_rooms() {
  places::test::World w;
  places::test::add_shell(w, {0.0, 0.0, 0.0}, {12.2, 6.0, 3.0});
  w.push_back({{6.0, 0.0, 0.0}, {6.2, 4.4, 3.0}});
  w.push_back({{6.0, 5.6, 0.0}, {6.2, 6.0, 3.0}});
  w.push_back({{6.0, 4.4, 2.1}, {6.2, 5.6, 3.0}});
  return w;
}

/// The first vehicle has mapped one room, the second the other one, in an odom of its own.
class SightLinesTest : public testing::Test {
 protected:
  SightLinesTest() {
    const places::test::World world = two_rooms();
    Rng rng(7);
    const geometry::SE3 start[2] = {at(3.0, 3.0, 0.0), at(9.0, 3.0, 90.0)};
    for (std::size_t path = 0; path < 2; ++path) {
      PathSubmap piece;
      piece.path = path;
      piece.submap = places::test::map_of(world, places::test::path(start[path], 3), rng);
      pieces_.push_back(std::move(piece));
      frames_.group.push_back(0);
      // The submap's frame is that of the middle scan; odom is at its start pose.
      frames_.T_map_odom.push_back(start[path]);
    }
    frames_.groups = {{0, 1}};
  }

  [[nodiscard]] int surfaces(const Vec3& p_m, const Vec3& q_m) const {
    return SightLines(pieces_, frames_, 0).surfaces(p_m, q_m);
  }

  [[nodiscard]] JointRanges range(double t_s, const Vec3& p_m, const Vec3& q_m) const {
    JointRanges joint;
    joint.pairs = {{{0, 0}, {1, 0}}};
    JointRange r;
    r.t = Time::from_s(t_s);
    r.a.p_odom_m = frames_.T_map_odom[0].inverse() * p_m;
    r.b.p_odom_m = frames_.T_map_odom[1].inverse() * q_m;
    r.range_m = (q_m - p_m).norm();
    r.sigma_m = 0.1;
    joint.ranges.push_back(r);
    return joint;
  }

  std::vector<PathSubmap> pieces_;
  PathFrames frames_;
};

TEST_F(SightLinesTest, counts_no_surface_between_two_points_in_one_room) {
  EXPECT_EQ(surfaces({1.0, 1.0, 0.8}, {5.0, 5.0, 0.9}), 0);
  EXPECT_EQ(surfaces({7.0, 1.0, 0.8}, {11.0, 5.0, 0.9}), 0);
  EXPECT_EQ(surfaces({2.0, 2.0, 0.8}, {2.0, 2.0, 0.8}), 0);
}

TEST_F(SightLinesTest, counts_two_surfaces_through_a_wall_mapped_from_both_sides) {
  EXPECT_EQ(surfaces({4.0, 2.0, 0.8}, {8.0, 2.5, 0.8}), 2);
  EXPECT_EQ(surfaces({8.0, 2.5, 0.8}, {4.0, 2.0, 0.8}), 2);
}

TEST_F(SightLinesTest, counts_no_surface_through_an_open_door) {
  EXPECT_EQ(surfaces({4.0, 5.0, 0.8}, {8.0, 5.0, 0.8}), 0);
}

TEST_F(SightLinesTest, is_left_by_a_line_that_goes_on_behind_an_outer_wall) {
  SightLines lines(pieces_, frames_, 0);
  EXPECT_TRUE(lines.leaves({3.0, 3.0, 0.8}, {3.0, -9.0, 0.8}));
  EXPECT_FALSE(lines.leaves({1.0, 1.0, 0.8}, {5.0, 5.0, 0.8}));
  EXPECT_FALSE(lines.leaves({4.0, 5.0, 0.8}, {8.0, 5.0, 0.8})) << "through the door";
}

TEST_F(SightLinesTest, ignores_scans_of_a_vehicle_in_another_frame_group) {
  frames_.group[1] = 1;
  EXPECT_EQ(surfaces({4.0, 2.0, 0.8}, {8.0, 2.5, 0.8}), 1);
}

TEST_F(SightLinesTest, multiplies_the_sigma_of_a_range_through_a_wall_by_five) {
  const ranging::RangingSettings settings;
  JointRanges through = range(1.0, {4.0, 2.0, 0.8}, {8.0, 2.5, 0.8});
  suspect_through_walls(pieces_, frames_, settings, FramesAre::kFound, through);
  EXPECT_TRUE(through.ranges[0].blocked);
  EXPECT_NEAR(through.ranges[0].sigma_m, 0.5, 0.001);  // five times 0.1 m

  JointRanges free = range(1.0, {4.0, 5.0, 0.8}, {8.0, 5.0, 0.8});
  suspect_through_walls(pieces_, frames_, settings, FramesAre::kFound, free);
  EXPECT_FALSE(free.ranges[0].blocked);
  EXPECT_EQ(free.ranges[0].sigma_m, 0.1);
}

TEST_F(SightLinesTest,
       lets_a_range_contradict_a_supposed_frame_although_its_line_leaves_the_rooms) {
  const ranging::RangingSettings settings;
  JointRanges supposed = range(1.0, {3.0, 3.0, 0.8}, {3.0, -9.0, 0.8}), found = supposed;
  suspect_through_walls(pieces_, frames_, settings, FramesAre::kSupposed, supposed);
  EXPECT_FALSE(supposed.ranges[0].blocked);
  suspect_through_walls(pieces_, frames_, settings, FramesAre::kFound, found);
  EXPECT_TRUE(found.ranges[0].blocked);
}

TEST_F(SightLinesTest, checks_line_of_sight_separately_for_each_range) {
  const ranging::RangingSettings settings;
  JointRanges joint = range(1.0, {4.0, 2.0, 0.8}, {8.0, 2.5, 0.8});
  joint.ranges.push_back(range(1.1, {4.0, 5.0, 0.8}, {8.0, 5.0, 0.8}).ranges[0]);
  suspect_through_walls(pieces_, frames_, settings, FramesAre::kFound, joint);
  EXPECT_TRUE(joint.ranges[0].blocked);
  EXPECT_FALSE(joint.ranges[1].blocked);
}

TEST_F(SightLinesTest, keeps_a_larger_sigma_reported_by_the_vehicle) {
  JointRanges joint = range(1.0, {4.0, 2.0, 0.8}, {8.0, 2.5, 0.8});
  joint.ranges[0].sigma_m = 0.9;
  suspect_through_walls(pieces_, frames_, {}, FramesAre::kFound, joint);
  EXPECT_EQ(joint.ranges[0].sigma_m, 0.9);
}

}  // namespace
}  // namespace rali::fleet
