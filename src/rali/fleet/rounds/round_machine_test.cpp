#include "rali/fleet/rounds/round_machine.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

VehicleId id(int v) { return VehicleId{static_cast<std::uint16_t>(v)}; }

Time at(double t_s) { return Time::from_s(t_s); }

Stand stand(int v, double start_s, double end_s) { return {id(v), at(start_s), at(end_s)}; }

map::FrontierArea area(std::uint32_t number, map::FrontierState state, double x_m = 0.0) {
  map::FrontierArea f;
  f.id = number;
  f.state = state;
  f.centre_map_m = {x_m, 1.0};
  f.length_m = 2.0;
  f.nearest = 1;
  return f;
}

TEST(RoundMachine, reports_a_mission_of_two_rounds) {
  RoundMachine machine{RoundSettings{}};
  EXPECT_EQ(machine.round(), 0U);
  EXPECT_FALSE(machine.anchor().has_value());
  machine.anchor_began(id(0), at(10.0));
  machine.anchor_began(id(0), at(12.0), false);  // a new term of the same
  EXPECT_EQ(machine.round(), 1U);
  EXPECT_EQ(machine.anchor(), std::optional(id(0)));
  machine.tag_finished(id(1), FinishReason::kExplored);
  machine.tag_finished(id(1), FinishReason::kNone);
  EXPECT_EQ(machine.finished(id(1)), FinishReason::kNone);
  machine.tag_finished(id(1), FinishReason::kDistance);
  EXPECT_EQ(machine.finished(id(1)), FinishReason::kDistance);
  machine.anchor_ended(RoundEnd::kFinished, at(60.0));
  EXPECT_FALSE(machine.anchor().has_value());
  machine.next_chosen(id(1), 7);
  machine.anchor_began(id(1), at(65.0));
  EXPECT_EQ(machine.finished(id(1)), FinishReason::kNone) << "of the round before";
  machine.end_of_data(at(100.0));
  machine.end_of_data(at(200.0));
  const auto& rows = machine.rounds();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0], (RoundRow{1, id(0), at(10.0), at(60.0), RoundEnd::kFinished, id(1), 7}));
  EXPECT_EQ(rows[1].start, at(65.0));
  EXPECT_EQ(*rows[1].end, at(100.0));
  EXPECT_EQ(name_of(rows[1].ended_by), "end_of_data");
}

TEST(RoundMachine, reports_a_lost_anchor_if_another_takes_over) {
  RoundMachine machine{RoundSettings{}};
  machine.anchor_began(id(0), at(0.0));
  machine.anchor_began(id(2), at(40.0));
  EXPECT_EQ(machine.rounds()[0].ended_by, RoundEnd::kAnchorLost);
  EXPECT_EQ(machine.rounds()[0].next_anchor, std::optional(id(2)));
}

TEST(RoundMachine, ends_the_mission_after_two_complete_searches_without_an_open_frontier) {
  RoundMachine machine{RoundSettings{}};
  machine.anchor_began(id(0), at(0.0));
  const std::vector<VehicleId> two = {id(0), id(1)};
  const std::vector<map::FrontierArea> open = {area(1, map::FrontierState::kOpen)};
  const std::vector<map::FrontierArea> small = {area(1, map::FrontierState::kTooSmall)};
  machine.frontiers_seen(open, two, true);
  machine.frontiers_seen(small, two, true);
  machine.frontiers_seen(open, two, true);
  machine.frontiers_seen(small, two, true);
  EXPECT_FALSE(machine.mission_over()) << "not in a row";
  machine.frontiers_seen(small, two, false);
  EXPECT_FALSE(machine.mission_over()) << "keyframes were missing";
  machine.frontiers_seen(small, two, true);
  EXPECT_TRUE(machine.mission_over());
}

TEST(RoundMachine, lists_each_frontier_of_a_round_with_its_reason) {
  RoundMachine machine{RoundSettings{}};
  const std::vector<VehicleId> two = {id(4), id(5)};
  machine.anchor_began(id(0), at(0.0));
  machine.frontiers_seen(
      std::vector{area(1, map::FrontierState::kOpen, 3.0), area(2, map::FrontierState::kOpen, 8.0)},
      two, true);
  machine.frontiers_seen(std::vector{area(2, map::FrontierState::kUnreachable, 8.0),
                                     area(3, map::FrontierState::kOpen, 12.0)},
                         two, true);
  machine.anchor_ended(RoundEnd::kFinished, at(50.0));
  const auto& rows = machine.frontiers();
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].id, 2U);
  EXPECT_EQ(name_of(rows[0].state), "unreachable");
  EXPECT_FALSE(rows[0].nearest_vehicle.has_value());
  EXPECT_EQ(rows[1].id, 3U);
  EXPECT_EQ(rows[1].nearest_vehicle, std::optional(id(5)));
  EXPECT_EQ(rows[2].id, 1U);
  EXPECT_EQ(name_of(rows[2].state), "explored");
  EXPECT_EQ(rows[2].reason, "seen");
  for (const FrontierRow& row : rows) EXPECT_EQ(row.round, 1U);
}

TEST(RoundMachine, reports_what_blocked_the_frontiers_left_at_the_end) {
  RoundMachine machine{RoundSettings{}};
  machine.anchor_began(id(0), at(0.0));
  const std::vector<VehicleId> two = {id(0), id(1)};
  const std::vector open = {area(1, map::FrontierState::kOpen, 3.0),
                            area(2, map::FrontierState::kOpen, 8.0)};
  machine.frontiers_seen(open, two, true);
  machine.frontier_stopped(2, "another vehicle blocks every path to it");
  machine.anchor_ended(RoundEnd::kFinished, at(50.0));
  const auto& rows = machine.frontiers();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].reason, "0 m2 unknown behind it");
  EXPECT_EQ(rows[1].reason, "another vehicle blocks every path to it");
  EXPECT_EQ(rows[1].state, map::FrontierState::kOpen);
}

TEST(StandFinder, finds_standstills_of_at_least_three_seconds) {
  StandFinder finder(id(1), 3.0);
  for (int k = 0; k <= 100; ++k) {
    const double t = 0.1 * k;
    finder.add(at(t), (t > 0.95 && t < 3.05) || (t > 3.95 && t < 8.05));  // 1-3 and 4-8
  }
  const auto stands = finder.stands();
  ASSERT_EQ(stands.size(), 1U);
  EXPECT_NEAR(stands[0].start.s(), 4.0, 1e-6);
  EXPECT_NEAR(stands[0].end.s(), 8.0, 1e-6);
}

TEST(StandFinder, ends_a_standstill_at_a_data_gap_and_keeps_the_last_one) {
  StandFinder finder(id(1), 3.0);
  for (int k = 0; k <= 40; ++k) finder.add(at(0.1 * k), true);
  for (int k = 0; k <= 40; ++k) finder.add(at(20.0 + 0.1 * k), true);
  const auto stands = finder.stands();
  ASSERT_EQ(stands.size(), 2U);
  EXPECT_NEAR(stands[0].end.s(), 4.0, 1e-6);
  EXPECT_NEAR(stands[1].start.s(), 20.0, 1e-6);
  EXPECT_NEAR(stands[1].end.s(), 24.0, 1e-6);
  finder.add(at(1.0), true);  // time runs backwards
  EXPECT_EQ(finder.stands().size(), 2U);
}

TEST(RoundsOfStands, leapfrog_driving_gives_one_round_per_standstill) {
  // Both at the start, then in turn; v2 alone moves first.
  const std::vector<Stand> stands = {stand(1, 0, 40), stand(2, 0, 5), stand(2, 35, 90),
                                     stand(1, 85, 120)};
  const auto rows = rounds_of_stands(stands, 3.0);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].anchor, id(1));
  EXPECT_EQ(rows[0].start, at(0));
  EXPECT_EQ(*rows[0].end, at(40));
  EXPECT_EQ(rows[0].next_anchor, std::optional(id(2)));
  EXPECT_EQ(rows[1].anchor, id(2));
  EXPECT_EQ(rows[1].start, at(40)) << "it stood before, but the round was another's";
  EXPECT_EQ(*rows[1].end, at(90));
  EXPECT_EQ(rows[2].anchor, id(1));
  EXPECT_EQ(*rows[2].end, at(120));
}

TEST(RoundsOfStands, leaves_intervals_without_an_anchor_open) {
  const std::vector<Stand> stands = {stand(2, 50, 60), stand(1, 10, 20), stand(3, 12, 14)};
  const auto rows = rounds_of_stands(stands, 3.0);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].anchor, id(1));
  EXPECT_EQ(rows[0].start, at(10));
  EXPECT_EQ(*rows[0].end, at(20));
  EXPECT_EQ(rows[1].anchor, id(2));
  EXPECT_EQ(rows[1].start, at(50));
  EXPECT_TRUE(rounds_of_stands({}, 3.0).empty());
}

TEST(RoundsOfTable, are_as_written_and_errors_name_the_row) {
  const std::vector<Stand> good = {stand(1, 0, 10), stand(2, 10, 30)};
  const auto rows = rounds_of_table(good);
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ((*rows)[0].next_anchor, std::optional(id(2)));
  EXPECT_EQ(*(*rows)[1].end, at(30));
  const auto backwards = rounds_of_table(std::vector<Stand>{stand(1, 0, 10), stand(2, 30, 20)});
  ASSERT_FALSE(backwards.has_value());
  EXPECT_EQ(backwards.error().where, "row 2");
  EXPECT_FALSE(backwards.error().remedy.empty());
  const auto overlap = rounds_of_table(std::vector<Stand>{stand(1, 0, 10), stand(2, 9, 20)});
  ASSERT_FALSE(overlap.has_value());
  EXPECT_EQ(overlap.error().code, ErrorCode::kInput);
  EXPECT_TRUE(rounds_of_table({})->empty());
}

TEST(Names, are_those_of_the_tables) {
  EXPECT_EQ(name_of(RoundEnd::kAnchorMoved), "anchor_moved");
  EXPECT_EQ(name_of(FinishReason::kRangeLost), "range_lost");
  EXPECT_EQ(name_of(map::FrontierState::kTooSmall), "too_small");
}

}  // namespace
}  // namespace rali::fleet
