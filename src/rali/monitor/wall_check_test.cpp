#include "rali/monitor/wall_check.hpp"

#include <gtest/gtest.h>

namespace rali::monitor {
namespace {

WallSight sight(double t_s, std::size_t looks, std::size_t passes) {
  return {Time::from_s(t_s), looks, passes, 0, 0};
}

TEST(WallCheck, rays_through_1_5_percent_of_the_walls_are_no_contradiction) {
  std::vector<WallSight> lines_of_sight;
  for (int i = 0; i < 100; ++i) lines_of_sight.push_back(sight(i, 20000, 300));  // 1.5 %
  EXPECT_TRUE(check_walls(lines_of_sight, {}).empty());
}

TEST(WallCheck, consecutive_keyframes_with_rays_through_walls_give_one_interval) {
  std::vector<WallSight> lines_of_sight;
  for (int i = 0; i < 100; ++i) {
    const bool wrong = i >= 40 && i <= 50;
    lines_of_sight.push_back(sight(i, 20000, wrong ? 1600 + (i == 45 ? 400 : 0) : 100));
  }
  const auto found = check_walls(lines_of_sight, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].when.begin, Time::from_s(40.0));
  EXPECT_EQ(found[0].when.end, Time::from_s(50.0));
  EXPECT_NEAR(found[0].ratio, 0.1, 1e-9);
}

TEST(WallCheck, keyframes_29_s_apart_give_two_intervals) {
  const std::vector<WallSight> lines_of_sight{sight(0.0, 5000, 600), sight(1.0, 5000, 10),
                                              sight(30.0, 5000, 700)};
  EXPECT_EQ(check_walls(lines_of_sight, {}).size(), 2U);
}

// A corridor with walls of glass and a mirror at its end: 5.5 % in one keyframe, poses right to 1
// cm.
TEST(WallCheck, one_keyframe_alone_little_beyond_the_limit_is_no_contradiction) {
  std::vector<WallSight> lines_of_sight;
  for (int i = 0; i < 100; ++i) lines_of_sight.push_back(sight(i, 20000, i == 40 ? 1100 : 900));
  EXPECT_TRUE(check_walls(lines_of_sight, {}).empty());
  EXPECT_FALSE(looks_through(lines_of_sight, {}));
  lines_of_sight[43] = sight(43.0, 20000, 1100);
  ASSERT_EQ(check_walls(lines_of_sight, {}).size(), 1U) << "two within 5 s";
  EXPECT_TRUE(looks_through(lines_of_sight, {}));
}

// Two vehicles in one map at wrong poses: walls do not show which of the two is wrong.
TEST(WallCheck, keyframes_that_first_saw_the_passed_walls_are_reported_too) {
  std::vector<WallSight> lines_of_sight{{Time::from_s(1.0), 20000, 100, 1000, 400},
                                        {Time::from_s(2.0), 20000, 100, 1000, 30},
                                        {Time::from_s(3.0), 20000, 100, 100, 80}};
  const auto found = check_walls(lines_of_sight, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].when.begin, Time::from_s(1.0));
  EXPECT_EQ(found[0].when.end, Time::from_s(1.0));
  EXPECT_FALSE(found[0].looks);
  EXPECT_NEAR(found[0].ratio, 0.4, 1e-9);
}

// A corridor that another vehicle has placed across one's own: a few hundred places among
// thousands.
TEST(WallCheck, walls_of_other_vehicles_have_their_own_pass_ratio) {
  WallSight crossing = sight(1.0, 20000, 500);
  crossing.others_looks = 450;
  crossing.others_passes = 430;
  const auto found = check_walls(std::vector<WallSight>{crossing}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].looks);
  EXPECT_TRUE(found[0].of_others);
  EXPECT_NEAR(found[0].ratio, 430.0 / 450.0, 1e-9);
  EXPECT_TRUE(looks_through(std::vector<WallSight>{crossing}, {}));
}

// A truck that has left since the other vehicle saw it.
TEST(WallCheck, walls_passed_by_rays_of_one_vehicle_only_are_no_contradiction) {
  WallSight through = sight(1.0, 20000, 500);
  through.others_looks = 450;
  through.others_passes = 430;
  const auto contradicts = [](const std::vector<std::vector<WallSight>>& vehicles) {
    return looks_through(vehicles[0], settings_for(vehicles, {}));
  };
  EXPECT_FALSE(contradicts({{through}, {sight(1.0, 20000, 500)}}));
  EXPECT_TRUE(contradicts({{through}, {through}}));
}

TEST(WallCheck, rays_through_few_walls_of_other_vehicles_are_no_contradiction) {
  WallSight usual = sight(1.0, 20000, 500);
  usual.others_looks = 4000;
  usual.others_passes = 400;
  WallSight few = sight(2.0, 20000, 90);
  few.others_looks = few.others_passes = 90;
  EXPECT_TRUE(check_walls(std::vector<WallSight>{usual, few}, {}).empty());
}

TEST(WallCheck, keyframes_with_few_walls_in_view_are_not_checked) {
  EXPECT_TRUE(check_walls(std::vector<WallSight>{sight(0.0, 700, 50)}, {}).empty());
  EXPECT_FALSE(looks_through(std::vector<WallSight>{sight(0.0, 700, 50)}, {}));
  EXPECT_TRUE(looks_through(std::vector<WallSight>{sight(0.0, 2400, 400)}, {}));
  EXPECT_EQ(judged(std::vector<WallSight>{sight(0.0, 700, 50), sight(1.0, 5000, 0)}, {}), 1U);
}

TEST(WallCheck, a_single_keyframe_suffices_for_a_contradiction) {
  EXPECT_EQ(check_walls(std::vector<WallSight>{sight(0.0, 2400, 400)}, {}).size(), 1U);
}

}  // namespace
}  // namespace rali::monitor
