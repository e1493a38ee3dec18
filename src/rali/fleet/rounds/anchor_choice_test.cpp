#include "rali/fleet/rounds/anchor_choice.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/fleet/rounds/assignment.hpp"
#include "rali/fleet/rounds/plan_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;
using test::corridor_with_room;
using test::id;

const std::vector<AnchorCandidate> kThree = {
    {id(1), {0.0, 0.0}}, {id(2), {24.0, 0.0}}, {id(3), {9.0, 6.0}}};
const std::vector<FrontierSpot> kTwo = {{1, {30.0, 0.0}, 4.0}, {2, {10.0, 12.0}, 9.0}};

// T22.
TEST(NearestToLargest, matches_the_hand_computed_example) {
  const auto chosen = nearest_to_largest(kThree, kTwo);
  ASSERT_TRUE(chosen.has_value());
  EXPECT_EQ(chosen->vehicle, id(3));
  EXPECT_EQ(chosen->frontier, 1U);
  EXPECT_NEAR(chosen->distance_m, 6.083, 5e-4);
  EXPECT_NEAR((kThree[0].place_map_m - kTwo[1].centre_map_m).norm(), 15.620, 5e-4);
  EXPECT_NEAR((kThree[1].place_map_m - kTwo[1].centre_map_m).norm(), 18.439, 5e-4);
}

TEST(NearestToLargest, breaks_ties_by_vehicle_number_and_uses_given_path_lengths) {
  const std::vector<AnchorCandidate> equal = {{id(7), {5.0, 0.0}}, {id(4), {-5.0, 0.0}}};
  const std::vector<FrontierSpot> one = {{1, {0.0, 0.0}, 3.0}};
  EXPECT_EQ(nearest_to_largest(equal, one)->vehicle, id(4));
  const auto paths = [](std::size_t i, std::size_t) { return i == 0 ? 6.0 : 60.0; };
  EXPECT_EQ(nearest_to_largest(equal, one, paths)->vehicle, id(7));
  EXPECT_FALSE(nearest_to_largest(equal, {}).has_value());
  EXPECT_FALSE(nearest_to_largest({}, one).has_value());
}

// T22.
TEST(Assignment, of_two_vehicles_to_three_frontiers_costs_11) {
  const auto chosen = assign({2, 3, {12, 7, 20, 9, 15, 4}});
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0], std::optional<std::size_t>(1));
  EXPECT_EQ(chosen[1], std::optional<std::size_t>(2));
}

TEST(Assignment, matches_brute_force) {
  Rng rng(7, "assignment");
  for (int run = 0; run < 200; ++run) {
    const std::size_t rows = 1 + rng.below(4), columns = 1 + rng.below(4);
    CostTable table{rows, columns, {}};
    for (std::size_t k = 0; k < rows * columns; ++k) table.cost.push_back(rng.uniform(-5.0, 9.0));
    const auto chosen = assign(table);
    double cost = 0.0;
    std::size_t count = 0;
    for (std::size_t r = 0; r < rows; ++r) {
      cost += chosen[r] ? table.at(r, *chosen[r]) : 0.0;
      count += chosen[r] ? 1 : 0;
    }
    EXPECT_EQ(count, std::min(rows, columns));
    EXPECT_NEAR(cost, test::least_by_trying(table), 1e-9);
  }
}

TEST(Assignment, skips_pairs_with_infinite_or_nan_cost) {
  const double no = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto chosen = assign({3, 2, {no, 5, no, 3, nan, no}});
  EXPECT_FALSE(chosen[0].has_value());  // v2 takes the second at a lower cost
  EXPECT_EQ(chosen[1], std::optional<std::size_t>(1));
  EXPECT_FALSE(chosen[2].has_value());
  EXPECT_TRUE(assign({0, 3, {}}).empty());
  EXPECT_EQ(assign({2, 0, {}}).size(), 2U);
}

TEST(LinkChance, is_one_half_at_the_range_limit) {
  const AnchorSettings settings;
  EXPECT_NEAR(link_chance(60.0, settings), 0.5, 1e-12);
  EXPECT_NEAR(link_chance(68.0, settings), 1.0 / (1.0 + std::exp(1.0)), 1e-12);
  EXPECT_GT(link_chance(5.0, settings), 0.99);
}

TEST(PredictPlaces, lie_every_2_m_along_the_path_and_at_its_end) {
  const std::vector<Vec2> path = {{0, 0}, {3, 0}, {3, 4}};
  const auto places = predict_places(path, {}, 2.0);
  ASSERT_EQ(places.size(), 4U);  // at 2, 4, 6 and the end at 7
  EXPECT_NEAR((places[0].place_map_m - Vec2(2, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((places[1].place_map_m - Vec2(3, 1)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((places[2].place_map_m - Vec2(3, 3)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((places[3].place_map_m - Vec2(3, 4)).norm(), 0.0, 1e-9);
}

/// The corridor of 10.3: 16 places from 5 to 45 m, degenerate along it.
std::vector<PredictedLandmark> along_corridor() {
  std::vector<PredictedLandmark> out;
  for (int k = 0; k < 16; ++k) {
    out.push_back({{5.0 + 40.0 * k / 15.0, 0.0}, Vec2(1.0, 0.0)});
  }
  return out;
}

TEST(AnchorValue, matches_the_hand_computed_value_for_one_landmark) {
  const map::CellMap map = corridor_with_room();
  const std::vector<PredictedLandmark> one = {{{3.0, 0.4}, Vec2(1.0, 0.0)}};
  // 3 m ahead and 0.4 m lateral: c^2 = 9/9.16 saturates at 0.25.
  const AnchorSettings settings;
  EXPECT_NEAR(anchor_value({0.0, 0.0}, one, map, settings),
              1.0 / (1.0 + std::exp((std::sqrt(9.16) - 60.0) / 8.0)), 1e-9);
  // 0.1 m ahead and 0.4 m lateral: c^2 = 0.01/0.17, 0.2353 of c_sat^2.
  EXPECT_NEAR(anchor_value({2.9, 0.0}, one, map, settings), 0.01 / 0.17 / 0.25, 1e-3);
}

TEST(AnchorValue, is_high_along_a_degenerate_corridor_and_low_in_a_side_room) {
  const map::CellMap map = corridor_with_room();
  const AnchorSettings settings;
  const auto places = along_corridor();
  const double mouth = anchor_value({0.0, 0.0}, places, map, settings);
  const double side_room = anchor_value({25.0, 8.0}, places, map, settings);
  const double middle = anchor_value({25.0, 1.0}, places, map, settings);
  EXPECT_GT(mouth, 14.0);  // nearly one for each of the 16
  EXPECT_LT(side_room, 0.5);
  EXPECT_GT(middle, 14.0);
  std::vector<PredictedLandmark> seen = places;
  for (PredictedLandmark& q : seen) q.degenerate_axis.reset();
  EXPECT_EQ(anchor_value({0.0, 0.0}, seen, map, settings), 0.0);
}

/// Candidates whose rounds would all be equal.
std::vector<AnchorOption> options_of(const std::vector<AnchorCandidate>& candidates,
                                     const std::vector<PredictedLandmark>& predicted) {
  std::vector<AnchorOption> out;
  for (const AnchorCandidate& c : candidates) out.push_back({c, AnchorUse::kExplore, predicted});
  return out;
}

TEST(RankAnchors, informed_mode_prefers_the_corridor_axis_and_paper_mode_the_nearest) {
  const map::CellMap map = corridor_with_room();
  const auto passable = map::passable_cells(map, 0.3);
  // v1 in the side room is nearer to the frontier at the corridor's end than v2 at the mouth.
  const std::vector<AnchorCandidate> candidates = {{id(1), {25.0, 9.0}}, {id(2), {1.0, 0.0}}};
  const std::vector<FrontierSpot> frontiers = {{1, {45.0, 0.0}, 10.0}};
  AnchorSettings settings;
  settings.near_m = 2.0;
  const auto options = options_of(candidates, along_corridor());
  const auto informed = rank_anchors(options, frontiers, map, passable, settings);
  ASSERT_EQ(informed.size(), 2U);
  EXPECT_EQ(informed[0].vehicle, id(2));
  settings.choice = AnchorChoice::kPaper;
  settings.distance = FrontierDistance::kEuclid;
  const auto paper = rank_anchors(options, frontiers, map, passable, settings);
  EXPECT_EQ(paper[0].vehicle, id(1));
  EXPECT_NEAR(-paper[0].score, std::hypot(20.0, 9.0), 1e-9);
}

TEST(RankAnchors, moves_an_anchor_out_of_a_side_room_into_a_near_corridor) {
  const map::CellMap map = corridor_with_room();
  const auto passable = map::passable_cells(map, 0.3);
  const std::vector<AnchorCandidate> one = {{id(1), {25.0, 4.0}}};
  const std::vector<FrontierSpot> frontiers = {{1, {45.0, 0.0}, 10.0}};
  const auto ranked =
      rank_anchors(options_of(one, along_corridor()), frontiers, map, passable, AnchorSettings{});
  ASSERT_EQ(ranked.size(), 1U);
  EXPECT_LT(ranked[0].place_map_m.y(), 1.2) << "in the corridor";
  EXPECT_GT(ranked[0].path_m, 2.0);
  EXPECT_NEAR(ranked[0].score, ranked[0].value - 0.02 * ranked[0].path_m, 1e-12);
}

TEST(RankAnchors, without_degeneracy_falls_back_to_the_nearest) {
  const map::CellMap map = corridor_with_room();
  const auto passable = map::passable_cells(map, 0.3);
  const std::vector<AnchorCandidate> candidates = {{id(1), {1.0, 0.0}}, {id(2), {30.0, 0.0}}};
  const std::vector<FrontierSpot> frontiers = {{1, {45.0, 0.0}, 10.0}};
  const auto ranked =
      rank_anchors(options_of(candidates, {}), frontiers, map, passable, AnchorSettings{});
  EXPECT_EQ(ranked[0].vehicle, id(2));
  EXPECT_EQ(ranked[0].path_m, 0.0);
}

TEST(RankAnchors, ranks_a_vehicle_that_blocks_all_others_last) {
  const map::CellMap map = corridor_with_room();
  const auto passable = map::passable_cells(map, 0.3);
  const std::vector<FrontierSpot> frontiers = {{1, {45.0, 0.0}, 10.0}};
  // v1 has the corridor before it and v2 behind it, which sees as far but helps no vehicle there.
  std::vector<AnchorOption> options =
      options_of({{id(1), {4.0, 0.0}}, {id(2), {2.0, 0.0}}}, along_corridor());
  options[0].use = AnchorUse::kNone;
  for (const AnchorChoice choice : {AnchorChoice::kInformed, AnchorChoice::kPaper}) {
    AnchorSettings settings;
    settings.choice = choice;
    const auto ranked = rank_anchors(options, frontiers, map, passable, settings);
    ASSERT_EQ(ranked.size(), 2U);
    EXPECT_EQ(ranked[0].vehicle, id(2));
    options[0].use = AnchorUse::kExplore;
    EXPECT_EQ(rank_anchors(options, frontiers, map, passable, settings)[0].vehicle, id(1));
    options[0].use = AnchorUse::kNone;
    options[1].use = AnchorUse::kCloseUp;
    EXPECT_EQ(rank_anchors(options, frontiers, map, passable, settings)[0].vehicle, id(2));
    options[1].use = AnchorUse::kExplore;
  }
}

}  // namespace
}  // namespace rali::fleet
