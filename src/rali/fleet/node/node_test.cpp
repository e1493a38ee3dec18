#include "rali/fleet/node/node.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/node/node_fleet_for_test.hpp"

namespace rali::fleet {
namespace {

TEST(Node, the_first_vehicle_becomes_anchor_after_three_seconds_at_standstill) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(2.5);
  EXPECT_EQ(fleet.nodes[0].term(), 0U);
  fleet.run(1.5);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(fleet.nodes[0].term(), 1U);
  EXPECT_TRUE(fleet.did(1, RoleActionKind::kFollows));
  ASSERT_EQ(fleet.nodes[1].rounds().rounds().size(), 1U);
  EXPECT_EQ(fleet.nodes[1].rounds().rounds()[0].anchor, id(0));
}

// A "done" of a neighbouring fleet, of a later term, stopped the whole fleet.
TEST(Node, ignores_a_done_status_of_an_unknown_vehicle) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(4.0);
  VehicleStatus status;
  status.term = 99;
  status.mode = Mode::kDone;
  status.t_send = fleet.now;
  fleet.give(0, Envelope{id(7), std::nullopt, status});
  EXPECT_FALSE(fleet.nodes[0].done());
  fleet.give(0, Envelope{id(1), std::nullopt, status});
  EXPECT_TRUE(fleet.nodes[0].done());
}

TEST(Node, does_not_claim_the_anchor_role_before_it_is_levelled) {
  Fleet fleet(2);
  OwnPose pose;
  for (int k = 0; k < 80; ++k) {
    fleet.now = fleet.now + Duration::from_s(0.1);
    pose.t = fleet.now;
    pose.at_rest = true;
    fleet.give(0, pose);
    fleet.give(0, NodeTick{});
  }
  EXPECT_EQ(fleet.nodes[0].term(), 0U);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kStarting);
}

TEST(Node, a_tag_that_finishes_ends_the_round_and_the_role_is_handed_over) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(5.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(receive_weakly(fleet), FinishReason::kSignal);
  fleet.run(1.0);
  EXPECT_TRUE(fleet.did(0, RoleActionKind::kSealed));
  ASSERT_FALSE(fleet.nodes[0].rounds().rounds().empty());
  EXPECT_EQ(fleet.nodes[0].rounds().rounds()[0].ended_by, RoundEnd::kFinished);
  fleet.run(30.0);
  // Nothing is mapped, so no vehicle is better than the anchor itself: it continues in a new round.
  EXPECT_GE(fleet.nodes[0].term(), 2U);
  EXPECT_GE(fleet.nodes[1].rounds().rounds().size(), 2U);
}

// It discarded its map and the estimate of the finished rounds, and solved the whole mission again.
TEST(Node, an_anchor_elected_again_for_the_next_round_keeps_its_map) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(5.0);
  const Node& anchor = fleet.nodes[0];
  ASSERT_EQ(anchor.mode(), Mode::kAnchor);
  fleet.run(35.0);
  ASSERT_NE(anchor.mapper(), nullptr);
  const auto solved = [&] {
    return anchor.mapper()->work().whole + anchor.mapper()->work().rounds;
  };
  const std::size_t before = solved();
  EXPECT_GE(before, 3U);
  receive_weakly(fleet);
  for (int k = 0; k < 300 && anchor.rounds().rounds().size() < 2; ++k) fleet.step(0.1);
  ASSERT_EQ(anchor.rounds().rounds().size(), 2U);
  ASSERT_EQ(anchor.rounds().rounds()[1].anchor, id(0));
  ASSERT_NE(anchor.mapper(), nullptr);
  EXPECT_GE(solved(), before) << "it is the same one";
}

// The next anchor starts from the last one's messages. An anchor's own messages were missing when
// it became anchor again, and the other's estimate could not be used.
TEST(Node, an_anchor_keeps_the_keyframe_poses_that_it_broadcasts) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(5.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  ASSERT_FALSE(fleet.nodes[1].map_poses().empty());
  EXPECT_EQ(fleet.nodes[0].map_poses().size(), fleet.nodes[1].map_poses().size());
}

/// Two vehicles whose first anchor has just received that the second is the next.
Fleet handed_over(bool old_is_degenerate) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  if (old_is_degenerate) fleet.degenerate.insert(0);
  fleet.run(5.0);
  RoleMessage commit;
  commit.op = RoleOp::kCommit;
  commit.term = fleet.nodes[0].term() + 1;
  commit.candidate = id(1);
  fleet.silent.insert(1);
  fleet.give(0, Envelope{id(1), id(0), commit});
  return fleet;
}

TEST(Node, a_relieved_anchor_without_degeneracy_does_not_wait_for_ranges) {
  Fleet fleet = handed_over(false);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kHolding);
  fleet.run(4.0);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kExploring);
}

TEST(Node, a_relieved_degenerate_anchor_holds_until_the_new_anchor_ranges_to_it) {
  Fleet fleet = handed_over(true);
  fleet.run(4.0);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kHolding);
  for (int k = 0; k < 10; ++k) fleet.give(0, ReceivedRange{id(1), 2.0});
  fleet.run(0.3);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kExploring);
}

TEST(Node, a_tag_never_near_its_anchor_does_not_finish_for_weak_radio) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  for (int k = 0; k < 90; ++k) {
    fleet.give(1, ReceivedRadio{id(0), -90.0});
    fleet.step(0.1);
  }
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(fleet.nodes[0].rounds().finished(id(1)), FinishReason::kNone);
}

TEST(Node, a_tag_replaces_a_silent_anchor_only_with_a_majority) {
  Fleet fleet(3);
  for (std::size_t v = 0; v < 3; ++v) fleet.start(v);
  fleet.run(6.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  fleet.silent.insert(0);
  fleet.run(60.0);
  EXPECT_NE(fleet.nodes[0].mode(), Mode::kAnchor) << "its lease is over";
  const bool one = fleet.nodes[1].mode() == Mode::kAnchor;
  const bool two = fleet.nodes[2].mode() == Mode::kAnchor;
  EXPECT_NE(one, two);
  fleet.silent.insert(1);
  fleet.run(60.0);
  for (const Node& node : fleet.nodes) EXPECT_NE(node.mode(), Mode::kAnchor);
}

TEST(Node, a_goal_becomes_a_drive_order_and_its_removal_a_stop_order) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(5.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  ASSERT_TRUE(fleet.nodes[1].T_map_odom()) << "the table came";
  GoalList goals;
  goals.term = fleet.nodes[0].term();
  goals.revision = 1000;
  goals.goals.push_back({id(1), Vec3(7.0, 0.0, 0.0), 0U});
  fleet.give(1, Envelope{id(0), std::nullopt, goals});
  fleet.step(0.1);
  ASSERT_EQ(fleet.nodes[1].order().places_map_m.size(), 1U);
  EXPECT_EQ(fleet.nodes[1].order().places_map_m[0].x(), 7.0);
  const std::uint64_t number = fleet.nodes[1].order().number;
  goals.revision = 1001;
  fleet.give(1, Envelope{id(0), std::nullopt, goals});
  fleet.step(0.1);
  EXPECT_EQ(fleet.nodes[1].order().number, number) << "the same goal is no new order";
  goals.revision = 1002;
  goals.goals.clear();
  fleet.give(1, Envelope{id(0), std::nullopt, goals});
  fleet.step(0.1);
  EXPECT_TRUE(fleet.nodes[1].order().places_map_m.empty());
  EXPECT_EQ(fleet.nodes[1].order().number, number + 1);
}

TEST(Node, ignores_goals_from_a_vehicle_that_is_not_the_anchor) {
  Fleet fleet(3);
  for (std::size_t v = 0; v < 3; ++v) fleet.start(v);
  fleet.run(5.0);
  GoalList goals;
  goals.term = fleet.nodes[0].term();
  goals.revision = 1000;
  goals.goals.push_back({id(1), Vec3(7.0, 0.0, 0.0), 0U});
  fleet.give(1, Envelope{id(2), std::nullopt, goals});
  fleet.step(0.1);
  EXPECT_TRUE(fleet.nodes[1].order().places_map_m.empty());
}

TEST(Node, an_anchor_that_is_pushed_ends_its_round) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(5.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  fleet.moving.insert(0);
  fleet.run(0.8);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor) << "a sweep that seems to move is no push";
  fleet.run(1.0);
  ASSERT_FALSE(fleet.nodes[0].rounds().rounds().empty());
  EXPECT_EQ(fleet.nodes[0].rounds().rounds()[0].ended_by, RoundEnd::kAnchorMoved);
}

TEST(Node, same_events_give_the_same_messages) {
  const auto count = [] {
    Fleet fleet(3);
    for (std::size_t v = 0; v < 3; ++v) fleet.start(v);
    fleet.run(20.0);
    std::vector<std::uint64_t> out;
    for (const Node& node : fleet.nodes) out.push_back(node.store().hash());
    out.push_back(fleet.actions.size());
    return out;
  };
  const auto first = count();
  EXPECT_EQ(first, count());
  EXPECT_EQ(first[0], first[1]) << "all hold the same facts";
}

}  // namespace
}  // namespace rali::fleet
