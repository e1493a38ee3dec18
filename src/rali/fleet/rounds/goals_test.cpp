#include "rali/fleet/rounds/goals.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/fleet/rounds/plan_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;
using test::corridor_with_room;
using test::id;

const map::CellMap& map_of_test() {
  static const map::CellMap map = corridor_with_room();
  return map;
}

GoalPlan plan(const std::vector<Traveller>& travellers, std::optional<std::size_t> anchor,
              const std::vector<FrontierSpot>& frontiers, const GoalSettings& settings = {},
              const DegenerateAxisAt& degenerate = {}, const AnchorSettings& links = {}) {
  const auto passable = map::passable_cells(map_of_test(), 0.3);
  return plan_goals(travellers, anchor, frontiers, map_of_test(), passable, degenerate, links,
                    settings);
}

std::optional<Vec2> along_x(const Vec2& /*place*/) { return Vec2(1.0, 0.0); }

const FrontierSpot kEnd = {1, {49.5, 0.0}, 10.0};
const FrontierSpot kRoom = {2, {25.0, 9.0}, 4.0};

TEST(Goals, assign_one_vehicle_per_frontier_and_leave_the_rest_standing) {
  const auto out = plan({{id(1), {0.0, 0.0}, true, false, false},
                         {id(2), {2.0, 0.5}},
                         {id(3), {22.0, 0.5}},
                         {id(4), {-3.0, 0.0}}},
                        0, {kEnd, kRoom}, {0.5, 0.5, false});
  ASSERT_EQ(out.goals.size(), 4U);
  EXPECT_FALSE(out.goals[0].frontier.has_value()) << "the anchor stands";
  EXPECT_TRUE(out.goals[1].frontier.has_value());
  EXPECT_TRUE(out.goals[2].frontier.has_value());
  EXPECT_NE(*out.goals[1].frontier, *out.goals[2].frontier);
  EXPECT_FALSE(out.goals[3].frontier.has_value()) << "farthest from both";
  EXPECT_TRUE(out.goals[3].path_map_m.empty());
}

TEST(Goals, stop_before_the_frontier_and_stay_out_of_the_walls) {
  const auto out = plan({{id(2), {2.0, 0.5}}}, std::nullopt, {kRoom});
  const auto& path = out.goals[0].path_map_m;
  ASSERT_GE(path.size(), 3U);
  EXPECT_NEAR((path.front() - Vec2(2.0, 0.5)).norm(), 0.0, 0.2);
  EXPECT_NEAR((path.back() - kRoom.centre_map_m).norm(), 0.5, 0.2);
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    EXPECT_EQ(map::sight_fraction(map_of_test(), path[i], path[i + 1]), 1.0);
  }
}

TEST(Goals, are_empty_if_no_path_leads_to_a_frontier) {
  const auto out = plan({{id(2), {2.0, 0.5}}}, std::nullopt, {{1, {25.0, -2.8}, 99.0}});
  EXPECT_FALSE(out.goals[0].frontier.has_value());
}

TEST(Goals, end_at_the_radio_limit_in_a_degenerate_stretch) {
  AnchorSettings links;
  links.range_limit_m = 20.0;  // probability of one half there
  links.range_soft_m = 1.0;
  const std::vector<Traveller> two = {{id(1), {0.0, 0.0}, true, false, false}, {id(2), {2.0, 0.5}}};
  const auto out = plan(two, 0, {kEnd}, {}, along_x, links);
  ASSERT_TRUE(out.goals[1].frontier.has_value());
  EXPECT_EQ(out.goals[1].reach, Reach::kNoLink);
  EXPECT_LE(out.goals[1].path_map_m.back().x(), 20.1);
  EXPECT_GE(out.goals[1].path_map_m.back().x(), 17.0);
  EXPECT_GE(out.link_min, 0.5);
  const auto seeing = plan(two, 0, {kEnd}, {}, {}, links);
  EXPECT_FALSE(seeing.goals[1].is_cut()) << "where the LiDAR sees all no range is needed";
  EXPECT_GT(seeing.goals[1].path_map_m.back().x(), 48.0);
}

TEST(Goals, prefer_a_frontier_whose_whole_path_is_within_radio_range) {
  AnchorSettings links;
  links.range_limit_m = 32.0;
  links.range_soft_m = 1.0;
  // The room is smaller and its path longer, but the whole path to its door is linked.
  const auto degenerate_in_corridor = [](const Vec2& p) -> std::optional<Vec2> {
    if (p.y() > 1.5) return std::nullopt;
    return Vec2(1.0, 0.0);
  };
  const auto out = plan({{id(1), {0.0, 0.0}, true, false, false}, {id(2), {2.0, 0.5}}}, 0,
                        {{1, {49.5, 0.0}, 90.0}, kRoom}, {}, degenerate_in_corridor, links);
  ASSERT_TRUE(out.goals[1].frontier.has_value());
  EXPECT_EQ(*out.goals[1].frontier, 1U);
  EXPECT_FALSE(out.goals[1].is_cut());
}

TEST(Goals, lead_past_the_anchor_where_the_vehicle_starts_ahead_of_it) {
  const std::vector<Traveller> ahead = {{id(1), {10.0, 0.0}, true, false, false},
                                        {id(2), {14.0, 0.5}}};
  const auto out = plan(ahead, 0, {kEnd});
  EXPECT_TRUE(out.goals[1].passes);
  EXPECT_TRUE(leads_past(out.goals[1].path_map_m, {10.0, 0.0}, 4.0));
  GoalSettings without;
  without.pass_anchor = false;
  EXPECT_FALSE(plan(ahead, 0, {kEnd}, without).goals[1].passes);
  std::vector<Traveller> passed = ahead;
  passed[1].passed = true;
  EXPECT_LT(plan(passed, 0, {kEnd}).goals[1].path_m, out.goals[1].path_m - 2.0);
  std::vector<Traveller> far = ahead;
  far[1].place_map_m = {30.0, 0.5};
  EXPECT_FALSE(plan(far, 0, {kEnd}).goals[1].passes) << "40 m back and forth is too dear";
}

TEST(Goals, of_a_vehicle_behind_the_anchor_pass_it_without_detour) {
  const auto out =
      plan({{id(1), {10.0, -0.8}, true, false, false}, {id(2), {2.0, 0.5}}}, 0, {kEnd});
  EXPECT_TRUE(out.goals[1].passes);
  EXPECT_NEAR(out.goals[1].path_m, 47.0, 1.0);
}

TEST(Goals, of_a_warned_vehicle_lead_no_further_from_the_anchor) {
  const auto out =
      plan({{id(1), {0.0, 0.0}, true, false, false}, {id(2), {20.0, 0.5}, false, true, true}}, 0,
           {kEnd});
  EXPECT_TRUE(out.goals[1].path_map_m.empty());
  ASSERT_EQ(out.reach.size(), 1U);
  EXPECT_EQ(out.reach[0], Reach::kTooFar);
}

TEST(Goals, lead_around_a_standing_vehicle_or_end_behind_it_without_room) {
  // The corridor is 3 m wide, of which 2.4 m are left for the centre of a vehicle.
  std::vector<Traveller> column = {{id(1), {10.0, 0.0}, true}, {id(2), {2.0, 0.0}}};
  const auto past = plan(column, 0, {kEnd});
  ASSERT_TRUE(past.goals[1].frontier.has_value());
  EXPECT_EQ(past.goals[1].reach, Reach::kThere);
  double nearest_m = 99.0;
  for (const PredictedLandmark& q : predict_places(past.goals[1].path_map_m, {}, 0.05)) {
    nearest_m = std::min(nearest_m, (q.place_map_m - Vec2(10.0, 0.0)).norm());
  }
  EXPECT_GT(nearest_m, 0.65) << "0.8 m less the side of a cell";
  GoalSettings tight;
  tight.beside_m = 1.4;
  const auto behind = plan(column, 0, {kEnd}, tight);
  EXPECT_EQ(behind.goals[1].reach, Reach::kBlocked);
  ASSERT_FALSE(behind.goals[1].path_map_m.empty());
  EXPECT_NEAR(behind.goals[1].path_map_m.back().x(), 10.0 - tight.around_m, 0.3);
  column[1].wide = true;
  EXPECT_EQ(plan(column, 0, {kEnd}).goals[1].reach, Reach::kBlocked) << "it could not get past";
  column[1].place_map_m = {7.5, 0.0};
  EXPECT_FALSE(plan(column, 0, {kEnd}).goals[1].frontier.has_value()) << "it stands behind already";
  column[1].place_map_m = {2.0, 0.0};
  column[0].stands = false;
  EXPECT_EQ(plan(column, std::nullopt, {kEnd}).goals[0].reach, Reach::kThere)
      << "who drives off is in nobody's way";
}

TEST(Goals, end_behind_another_vehicle_only_if_no_frontier_is_free) {
  GoalSettings tight;
  tight.beside_m = 1.4;
  const std::vector<Traveller> column = {{id(1), {35.0, 0.0}, true}, {id(2), {30.0, 0.0}}};
  const auto out = plan(column, 0, {kEnd, kRoom}, tight);
  EXPECT_EQ(out.goals[1].frontier, 1U) << "the room behind it is farther";
  EXPECT_EQ(out.goals[1].reach, Reach::kThere);
}

TEST(Goals, never_include_a_frontier_that_the_vehicle_failed_to_reach) {
  std::vector<Traveller> two = {{id(1), {2.0, 0.5}}, {id(2), {22.0, 0.5}}};
  two[1].missed = {1};  // the room, to which it is nearer
  const auto out = plan(two, std::nullopt, {kEnd, kRoom});
  EXPECT_EQ(out.goals[0].frontier, 1U);
  EXPECT_EQ(out.goals[1].frontier, 0U);
  two[1].missed = {0, 1};
  EXPECT_FALSE(plan(two, std::nullopt, {kEnd, kRoom}).goals[1].frontier.has_value());
}

TEST(LeadsPast, requires_the_closest_point_inside_the_path) {
  EXPECT_TRUE(leads_past(std::vector<Vec2>{{-5, 1}, {5, 1}}, {0, 0}, 2.0));
  EXPECT_FALSE(leads_past(std::vector<Vec2>{{1, 1}, {9, 1}}, {0, 0}, 2.0)) << "only away";
  EXPECT_FALSE(leads_past(std::vector<Vec2>{{-5, 3}, {5, 3}}, {0, 0}, 2.0)) << "too far";
  EXPECT_FALSE(leads_past(std::vector<Vec2>{{0, 0}}, {0, 0}, 2.0));
  EXPECT_NEAR(length_of(std::vector<Vec2>{{0, 0}, {3, 0}, {3, 4}}), 7.0, 1e-12);
}

}  // namespace
}  // namespace rali::fleet
