// Several machines together, tables, and invalid messages.
#include <limits>

#include <gtest/gtest.h>

#include "rali/fleet/roles/role_vehicle_for_test.hpp"

namespace rali::fleet {
namespace {

using test::at;
using test::durable_of;
using test::has;
using test::id;
using test::Ops;
using test::ops;
using test::tag_of_three;
using test::Vehicle;

TEST(RoleFleet, the_survivor_of_two_becomes_anchor_only_after_the_operator_confirms) {
  Vehicle v(0, durable_of(2));
  v.receive(0.0, 1, RoleOp::kCommit, 1);
  EXPECT_TRUE(has(v.give(1.0, RoleFleet{{id(0)}}), RoleActionKind::kRefused)) << "v1 may act";
  for (double t = 6.0; t < 60.0; t += 1.0) v.tick(t);
  EXPECT_NE(v.state.mode, RoleMode::kAnchor);
  EXPECT_TRUE(has(v.give(60.0, RoleFleet{{id(1)}}), RoleActionKind::kRefused)) << "without itself";
  const RoleStep step = v.give(61.0, RoleFleet{{id(0)}});
  EXPECT_EQ(v.state.mode, RoleMode::kAnchor);
  EXPECT_TRUE(step.save);
  EXPECT_TRUE(may_publish(v.state, at(61.0)));
  for (double t = 62.0; t < 90.0; t += 1.0) v.tick(t);
  EXPECT_TRUE(may_publish(v.state, at(90.0))) << "alone it is a majority at any time";
}

TEST(RoleTable, is_accepted_only_from_the_current_anchor_and_never_older) {
  Vehicle v = tag_of_three();
  EXPECT_TRUE(accept_table(v.state, id(0), 1, 3));
  EXPECT_TRUE(accept_table(v.state, id(0), 1, 3)) << "another part of it";
  EXPECT_FALSE(accept_table(v.state, id(0), 1, 2));
  EXPECT_FALSE(accept_table(v.state, id(2), 1, 9));
  EXPECT_FALSE(accept_table(v.state, id(0), 2, 9));
  v.receive(1.0, 2, RoleOp::kCommit, 2);
  EXPECT_TRUE(accept_table(v.state, id(2), 2, 0));
}

TEST(RoleMessages, of_a_lower_term_are_refused_with_the_own_term) {
  Vehicle v(1);
  v.receive(0.0, 0, RoleOp::kCommit, 7);
  for (const RoleOp op : {RoleOp::kHeartbeat, RoleOp::kCommit, RoleOp::kPropose}) {
    const RoleStep step = v.receive(1.0, 2, op, 6, 2);
    ASSERT_EQ(ops(step), Ops{RoleOp::kRefuse});
    EXPECT_EQ(step.messages[0].message.term, 7U);
    EXPECT_EQ(step.messages[0].message.candidate, id(2));
  }
}

TEST(RoleMessages, with_invalid_terms_operations_or_senders_change_nothing) {
  Vehicle v = tag_of_three();
  const RoleState before = v.state;
  const std::uint64_t huge = std::numeric_limits<std::uint64_t>::max();
  for (const RoleOp op : {RoleOp::kHeartbeat, RoleOp::kAck, RoleOp::kFinished, RoleOp::kSeal,
                          RoleOp::kHandover, RoleOp::kPropose, RoleOp::kGrant, RoleOp::kRefuse,
                          RoleOp::kCommit, static_cast<RoleOp>(0), static_cast<RoleOp>(200)}) {
    EXPECT_TRUE(v.receive(1.0, 2, op, huge, 1).messages.empty());
    EXPECT_TRUE(v.receive(1.0, 99, op, 5, 1).messages.empty()) << "nobody of the fleet";
    EXPECT_TRUE(v.receive(1.0, 1, op, 5, 1).messages.empty()) << "its own echo";
  }
  EXPECT_EQ(v.state.durable, before.durable);
  EXPECT_EQ(v.state.promise_until, before.promise_until);
}

TEST(RoleMessages, of_two_anchors_in_one_term_are_reported) {
  Vehicle v = tag_of_three();
  EXPECT_TRUE(has(v.receive(1.0, 2, RoleOp::kHeartbeat, 1), RoleActionKind::kConflict));
  EXPECT_EQ(v.state.durable.anchor, std::optional(id(0)));
}

TEST(RoleFleetOfThree, goes_through_rounds_with_every_vehicle_in_turn) {
  test::RoleFleetSim sim(3, 5);
  sim.give(0, RoleClaim{});
  sim.run(2.0);
  ASSERT_EQ(sim.acting_anchor(), std::optional(0));
  for (int round = 0; round < 6; ++round) {
    const int anchor = *sim.acting_anchor();
    for (int v = 0; v < 3; ++v) {
      if (v != anchor) sim.give(v, RoleFinished{FinishReason::kDistance});
    }
    sim.run(8.0);
    ASSERT_EQ(sim.acting_anchor(), std::optional((anchor + 1) % 3));
    sim.run(10.0);
    EXPECT_EQ(sim.acting_anchor(), std::optional((anchor + 1) % 3)) << "finished was of the old";
  }
  EXPECT_EQ(sim.commits.size(), 7U);
}

TEST(RoleFleetOfThree, replaces_a_dead_anchor_within_half_a_minute) {
  test::RoleFleetSim sim(3, 6);
  sim.give(0, RoleClaim{});
  sim.run(5.0);
  sim.kill(0);
  sim.run(5.5);
  EXPECT_FALSE(sim.acting_anchor().has_value());
  sim.run(25.0);
  ASSERT_TRUE(sim.acting_anchor().has_value());
  EXPECT_NE(*sim.acting_anchor(), 0);
  sim.restart(0);
  sim.run(5.0);
  EXPECT_EQ(sim.node(0).state.mode, RoleMode::kTag);
  EXPECT_FALSE(sim.node(0).state.orphan);
}

TEST(RoleFleetOfFour, split_in_halves_has_no_anchor_until_it_is_whole_again) {
  test::RoleFleetSim sim(4, 7);
  sim.give(0, RoleClaim{});
  sim.run(5.0);
  sim.node(2).side = sim.node(3).side = 1;
  sim.run(60.0);
  EXPECT_FALSE(sim.acting_anchor().has_value());
  for (int v = 0; v < 4; ++v) EXPECT_TRUE(must_stand(sim.node(v).state)) << v;
  sim.node(2).side = sim.node(3).side = 0;
  sim.run(40.0);
  EXPECT_TRUE(sim.acting_anchor().has_value());
  EXPECT_EQ(sim.overlaps, 0);
}

}  // namespace
}  // namespace rali::fleet
