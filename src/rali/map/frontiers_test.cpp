#include "rali/map/frontiers.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

using geometry::Vec2;
using test::look_around;
using test::pose_at;
using test::Room;

/// A map from a picture, first line on top: '#' occupied, '.' free, ' ' unknown. Cells of 0.2 m,
/// corner at the origin.
CellMap drawn(const std::vector<std::string>& lines) {
  CellMap map;
  map.height = static_cast<int>(lines.size());
  map.width = static_cast<int>(lines.front().size());
  map.cells.resize(static_cast<std::size_t>(map.width * map.height));
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const char c =
          lines[static_cast<std::size_t>(map.height - 1 - y)][static_cast<std::size_t>(x)];
      map.cells[map.index({x, y})] = c == '#'   ? CellState::kOccupied
                                     : c == '.' ? CellState::kFree
                                                : CellState::kUnknown;
    }
  }
  return map;
}

std::vector<FrontierArea> found(const CellMap& map, const Vec2& start,
                                const FrontierSettings& settings, double radius_m = 0.0) {
  const auto passable = passable_cells(map, radius_m);
  const std::vector<PathField> from = {PathField(map, passable, start)};
  return find_frontiers(map, passable, from, settings);
}

const std::vector<std::string> kCorridor = {
    "####################", "#............       ", "#............       ", "#............       ",
    "#............       ", "#............       ", "#............       ", "####################"};

TEST(Frontiers, of_a_corridor_lie_between_free_and_unknown_cells) {
  const CellMap map = drawn(kCorridor);
  const auto list = found(map, {0.5, 0.7}, FrontierSettings{});
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].state, FrontierState::kOpen);
  EXPECT_EQ(list[0].cells.size(), 6U);
  EXPECT_NEAR(list[0].length_m, 1.2, 1e-9);
  EXPECT_NEAR(list[0].centre_map_m.x(), 2.5, 1e-9);  // column 12
  EXPECT_NEAR(list[0].size, 6.0, 1e-9);
  EXPECT_NEAR(list[0].path_m, 2.0, 1e-6);  // ten cells from column 2
}

TEST(Frontiers, keep_the_vehicle_radius_from_obstacles) {
  const CellMap map = drawn(kCorridor);
  const auto list = found(map, {0.5, 0.7}, FrontierSettings{}, 0.2);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].cells.size(), 4U);  // one cell less on each side
  EXPECT_EQ(list[0].state, FrontierState::kOpen) << "0.8 m for the centre of a vehicle";
}

TEST(Frontiers, without_a_path_are_marked_unreachable) {
  const CellMap map = drawn({"##########", "#...#.....", "#...#.....", "#...#.....", "#...#.....",
                             "#...#.....", "##########"});
  const auto list = found(map, {0.5, 0.5}, FrontierSettings{});
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].state, FrontierState::kUnreachable);
}

TEST(Frontiers, do_not_exist_in_a_fully_mapped_room) {
  const CellMap map = drawn({"#####", "#...#", "#...#", "#####"});
  EXPECT_TRUE(found(map, {0.5, 0.5}, FrontierSettings{}).empty());
}

TEST(Frontiers, of_an_l_shape_have_an_unknown_mean_and_a_free_medoid) {
  std::vector<std::string> lines(24, std::string(24, ' '));
  for (std::size_t k = 0; k < 24; ++k) {
    for (const std::size_t at : {0U, 1U}) lines[23 - at][k] = lines[k][at] = '.';
  }
  const CellMap map = drawn(lines);
  FrontierSettings settings;
  settings.centre = FrontierCentre::kMean;
  const auto mean = found(map, {0.1, 0.1}, settings);
  settings.centre = FrontierCentre::kMedoid;
  const auto medoid = found(map, {0.1, 0.1}, settings);
  ASSERT_EQ(mean.size(), 1U);
  ASSERT_EQ(medoid.size(), 1U);
  EXPECT_EQ(map.at(map.cell_at(mean[0].centre_map_m)), CellState::kUnknown);
  EXPECT_EQ(map.at(map.cell_at(medoid[0].centre_map_m)), CellState::kFree);
}

TEST(Frontiers, unknown_area_size_counts_the_connected_unknown_cells_behind_them) {
  const CellMap map =
      drawn({"########", "#....  #", "#....  #", "#....  #", "#....  #", "#....  #", "########"});
  FrontierSettings settings;
  settings.size = FrontierSize::kUnknownArea;
  const auto list = found(map, {0.5, 0.5}, settings);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_NEAR(list[0].size, 10 * 0.04, 1e-9);
}

TEST(Frontiers, none_stay_open_after_four_keyframes_in_a_closed_room) {
  ExploreGrid grid(ExploreSettings{});
  for (std::uint32_t k = 0; k < 4; ++k) {
    const auto s = look_around(Room{}, pose_at(5.0 + 3.0 * k, 5.0, 0.6, 0.4 * k), k, 900);
    ASSERT_TRUE(grid.add({VehicleId{0}, k}, s.view()));
  }
  const auto map = grid.picture();
  ASSERT_TRUE(map.has_value());
  const auto list = found(*map, {8.0, 5.0}, FrontierSettings{}, 0.3);
  for (const FrontierArea& f : list) {
    EXPECT_NE(f.state, FrontierState::kOpen)
        << f.centre_map_m.transpose() << " with " << f.cells.size() << " cells";
  }
}

TEST(Frontiers, of_a_long_corridor_are_open_20_m_ahead_of_the_vehicle) {
  const Room corridor{{0.0, 0.0, 0.0}, {80.0, 2.4, 2.6}, {}};
  ExploreGrid grid(ExploreSettings{});
  for (std::uint32_t k = 0; k < 6; ++k) {
    const auto s = look_around(corridor, pose_at(2.0 + k, 1.2, 0.6), k, 900);
    ASSERT_TRUE(grid.add({VehicleId{0}, k}, s.view()));
  }
  const auto map = grid.picture();
  ASSERT_TRUE(map.has_value());
  FrontierArea largest;
  for (const FrontierArea& f : found(*map, {2.0, 1.2}, FrontierSettings{}, 0.3)) {
    if (f.state != FrontierState::kOpen) continue;
    // The space behind the vehicle and beside it is known.
    EXPECT_GT(f.centre_map_m.x(), 15.0) << f.centre_map_m.transpose();
    if (f.size > largest.size) largest = f;
  }
  EXPECT_GE(largest.cells.size(), 8U);
  EXPECT_NEAR(largest.centre_map_m.x(), 27.0, 1.0);  // 20 m ahead of the last keyframe
  EXPECT_NEAR(largest.centre_map_m.y(), 1.2, 0.5);
}

TEST(FrontierBook, marks_a_frontier_explored_after_two_visits_without_change) {
  const CellMap map = drawn(kCorridor);
  FrontierBook book{FrontierSettings{}};
  const auto look = [&] {
    auto list = found(map, {0.5, 0.7}, FrontierSettings{});
    book.name(list);
    return list[0];
  };
  const FrontierArea first = look();
  book.visited(first.centre_map_m + Vec2(0.5, 0.0));
  EXPECT_EQ(look().state, FrontierState::kOpen);
  book.visited(first.centre_map_m + Vec2(5.0, 0.0));  // somewhere else
  EXPECT_EQ(look().state, FrontierState::kOpen);
  book.visited(first.centre_map_m);
  EXPECT_EQ(look().state, FrontierState::kExplored);
  EXPECT_EQ(look().id, first.id);
}

TEST(FrontierBook, a_shifted_frontier_keeps_its_id_and_resets_its_visits) {
  CellMap map = drawn(kCorridor);
  FrontierBook book{FrontierSettings{}};
  auto list = found(map, {0.5, 0.7}, FrontierSettings{});
  book.name(list);
  const std::uint32_t id = list[0].id;
  book.visited(list[0].centre_map_m);
  map.origin_map_m.x() += 1.0;
  list = found(map, {1.5, 0.7}, FrontierSettings{});
  book.name(list);
  EXPECT_EQ(list[0].id, id);
  book.visited(list[0].centre_map_m);
  book.name(list);
  EXPECT_EQ(list[0].state, FrontierState::kOpen);
}

// Regression: with a book per anchor, a new anchor sent a vehicle twice again to a frontier that
// had been visited twice, and gave it a new id.
TEST(FrontierBook, continues_ids_and_visits_from_the_memory_of_another_book) {
  const CellMap map = drawn(kCorridor);
  FrontierBook first{FrontierSettings{}};
  const auto look = [&map](FrontierBook& book) {
    auto list = found(map, {0.5, 0.7}, FrontierSettings{});
    book.name(list);
    return list[0];
  };
  const FrontierArea seen = look(first);
  first.visited(seen.centre_map_m);
  FrontierMemory memory = first.memory();
  ASSERT_FALSE(memory.named.empty());
  EXPECT_EQ(memory.last_id, memory.named.back().id);
  memory.last_id = 20;  // more were seen and are gone
  FrontierBook second{FrontierSettings{}};
  second.take(memory);
  EXPECT_EQ(look(second).id, seen.id);
  EXPECT_EQ(look(second).state, FrontierState::kOpen);
  second.visited(seen.centre_map_m);
  EXPECT_EQ(look(second).state, FrontierState::kExplored);
  CellMap away = map;
  away.origin_map_m.x() += 100.0;
  auto list = found(away, {100.5, 0.7}, FrontierSettings{});
  second.name(list);
  EXPECT_EQ(list[0].id, 21U) << "no name is given twice";
}

TEST(FrontierBook, marks_frontiers_unreachable_when_all_vehicles_failed_even_across_books) {
  const CellMap map = drawn(kCorridor);
  const std::vector<VehicleId> fleet = {VehicleId{0}, VehicleId{1}};
  const auto look = [&](FrontierBook& book) {
    auto list = found(map, {0.5, 0.7}, FrontierSettings{});
    book.name(list);
    book.give_up_unreached(list, fleet);
    return list[0];
  };
  FrontierBook first{FrontierSettings{}};
  const Vec2 centre = look(first).centre_map_m;
  for (int k = 0; k < 5; ++k) first.found_no_path(fleet[1], centre);
  EXPECT_EQ(look(first).state, FrontierState::kOpen) << "the other may get there";
  EXPECT_TRUE(first.has_no_path(fleet[1], centre + Vec2(0.3, 0.0)));
  EXPECT_FALSE(first.has_no_path(fleet[1], centre + Vec2(1.0, 0.0)));
  EXPECT_FALSE(first.has_no_path(fleet[0], centre));
  FrontierBook second{FrontierSettings{}};
  second.take(first.memory());
  second.found_no_path(fleet[0], centre);
  const FrontierArea given_up = look(second);
  EXPECT_EQ(given_up.state, FrontierState::kUnreachable);
  EXPECT_TRUE(given_up.tried);
}

TEST(PathField, finds_the_shortest_path_around_a_wall) {
  const CellMap map = drawn({".......", ".......", "..####.", ".......", "......."});
  const auto passable = passable_cells(map, 0.0);
  const PathField field(map, passable, {0.9, 0.3});  // cell 4, 1
  // To row 3 around the right end by these cells: (4,1)-(5,1)-(6,2)-(5,3)-(4,3).
  EXPECT_NEAR(field.length_m({4, 3}), 0.2 * (2.0 + 2.0 * std::sqrt(2.0)), 1e-6);
  const auto path = field.path_to({4, 3});
  ASSERT_GE(path.size(), 3U);
  EXPECT_EQ(path.front(), map.centre_m({4, 1}));
  EXPECT_EQ(path.back(), map.centre_m({4, 3}));
  EXPECT_FALSE(std::isfinite(field.length_m({3, 2})));
  EXPECT_FALSE(std::isfinite(field.length_m({-1, 99})));
  EXPECT_TRUE(field.path_to({3, 2}).empty());
}

TEST(PathField, starts_from_an_occupied_cell_but_not_outside_the_map) {
  const CellMap map = drawn({"........", "........", "########", "        "});
  const auto passable = passable_cells(map, 0.0);
  EXPECT_TRUE(std::isfinite(PathField(map, passable, {0.5, 0.3}).length_m({7, 3})));
  EXPECT_FALSE(std::isfinite(PathField(map, passable, {0.5, -9.0}).length_m({7, 3})));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(std::isfinite(PathField(map, passable, {nan, nan}).length_m({7, 3})));
}

TEST(SightFraction, is_zero_through_a_wall_and_half_through_unknown_cells) {
  const CellMap map =
      drawn({"..........#.........", "..........#.........", "..........          "});
  EXPECT_EQ(sight_fraction(map, {0.1, 0.5}, {1.9, 0.5}), 1.0);
  EXPECT_EQ(sight_fraction(map, {0.1, 0.5}, {3.9, 0.5}), 0.0);
  EXPECT_EQ(sight_fraction(map, {0.1, 0.1}, {3.9, 0.1}), 0.5);
  EXPECT_EQ(sight_fraction(map, {1.9, 0.5}, {3.9, 0.5}), 1.0)
      << "an obstacle at the end is a vehicle";
}

}  // namespace
}  // namespace rali::map
