// The state table of README.md, row by row, with L = 5 s and a heartbeat of 1 s.
#include "rali/fleet/roles/role_machine.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/roles/role_vehicle_for_test.hpp"

namespace rali::fleet {
namespace {

using test::anchor_of_three;
using test::at;
using test::durable_of;
using test::has;
using test::id;
using test::kPromise_s;
using test::Ops;
using test::ops;
using test::tag_of_three;
using test::Vehicle;

TEST(RoleTag, acknowledges_a_heartbeat_with_both_stamps_and_renews_its_promise) {
  Vehicle v = tag_of_three();
  RoleMessage beat;
  beat.op = RoleOp::kHeartbeat;
  beat.term = 1;
  beat.t_send = at(777.0);  // of another vehicle's clock
  const RoleStep step = v.give(2.0, RoleReceived{id(0), beat});
  ASSERT_EQ(ops(step), Ops{RoleOp::kAck});
  EXPECT_EQ(step.messages[0].to, std::optional(id(0)));
  EXPECT_EQ(step.messages[0].message.t_echo, at(777.0));
  EXPECT_EQ(step.messages[0].message.t_received, at(2.0));
  EXPECT_EQ(v.state.promise_until, at(2.0) + Duration::from_s(kPromise_s));
  EXPECT_FALSE(must_stand(v.state));
}

TEST(RoleTag, reports_its_finish_at_once_and_with_every_heartbeat_until_cleared) {
  Vehicle v = tag_of_three();
  RoleStep step = v.give(1.0, RoleFinished{FinishReason::kExplored});
  ASSERT_EQ(ops(step), Ops{RoleOp::kFinished});
  EXPECT_EQ(step.messages[0].message.reason, FinishReason::kExplored);
  EXPECT_TRUE(must_stand(v.state));
  step = v.receive(2.0, 0, RoleOp::kHeartbeat, 1);
  EXPECT_EQ(ops(step), (Ops{RoleOp::kAck, RoleOp::kFinished}));
  step = v.give(3.0, RoleFinished{FinishReason::kNone});
  ASSERT_EQ(ops(step), Ops{RoleOp::kFinished});
  EXPECT_EQ(step.messages[0].message.reason, FinishReason::kNone);
  EXPECT_EQ(ops(v.receive(4.0, 0, RoleOp::kHeartbeat, 1)), Ops{RoleOp::kAck});
}

TEST(RoleTag, is_orphaned_after_one_lease_and_a_candidate_after_two_at_standstill) {
  Vehicle v = tag_of_three();
  v.give(5.0, RoleLink{id(2)});
  EXPECT_FALSE(has(v.tick(5.1), RoleActionKind::kOrphaned));
  EXPECT_TRUE(has(v.tick(5.3), RoleActionKind::kOrphaned));
  EXPECT_TRUE(must_stand(v.state));
  v.tick(10.1);
  EXPECT_EQ(v.state.mode, RoleMode::kTag) << "2 L (1 + 0.02) = 10.2 s have not passed";
  v.give(15.0, RoleSelf{std::nullopt, 0});
  v.give(15.0, RoleLink{id(2)});
  v.tick(15.3);  // at the latest, with all of its jitter
  EXPECT_EQ(v.state.mode, RoleMode::kTag) << "it moves";
  v.give(16.0, RoleSelf{at(12.0), 0});
  const RoleStep step = v.tick(16.0);
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
  EXPECT_EQ(v.state.durable.term, 2U);
  EXPECT_EQ(v.state.durable.granted_to, std::optional(id(1)));
  EXPECT_EQ(ops(step), Ops{RoleOp::kPropose});
  EXPECT_TRUE(step.save);
}

TEST(RoleTag, without_any_link_does_not_raise_the_term) {
  Vehicle v = tag_of_three();
  for (double t = 1.0; t < 100.0; t += 1.0) v.tick(t);
  EXPECT_EQ(v.state.durable.term, 1U);
  EXPECT_TRUE(v.state.orphan);
}

TEST(RoleTag, becomes_candidate_only_when_named_after_three_seconds_at_standstill) {
  Vehicle v = tag_of_three();
  v.give(1.0, RoleSelf{at(0.0), 0});
  v.receive(1.0, 0, RoleOp::kSeal, 1);
  EXPECT_TRUE(must_stand(v.state));
  v.receive(2.0, 0, RoleOp::kHandover, 2, 1);
  EXPECT_EQ(v.state.mode, RoleMode::kTag) << "has stood for 2 s only";
  v.receive(2.5, 0, RoleOp::kHandover, 2, 2);
  const RoleStep step = v.receive(3.0, 0, RoleOp::kHandover, 2, 1);
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
  EXPECT_EQ(v.state.durable.term, 2U);
  EXPECT_EQ(ops(step), Ops{RoleOp::kPropose});
}

TEST(RoleTag, ignores_a_handover_from_an_old_anchor_while_another_is_active) {
  Vehicle v(1);
  v.receive(0.0, 2, RoleOp::kCommit, 2);
  v.receive(1.0, 0, RoleOp::kHandover, 3, 1);
  EXPECT_EQ(v.state.mode, RoleMode::kTag) << "v2 acts until 5.2 s at least";
  v.receive(5.3, 0, RoleOp::kHandover, 3, 1);
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
}

TEST(RoleVote, is_given_once_per_term_after_the_seal_or_the_promise) {
  Vehicle v = tag_of_three();
  EXPECT_EQ(ops(v.receive(1.0, 2, RoleOp::kPropose, 2, 2)), Ops{RoleOp::kRefuse});
  EXPECT_EQ(v.state.durable.term, 1U);
  v.receive(2.0, 0, RoleOp::kSeal, 1);
  const RoleStep step = v.receive(2.1, 2, RoleOp::kPropose, 2, 2);
  ASSERT_EQ(ops(step), Ops{RoleOp::kGrant});
  EXPECT_TRUE(step.save) << "on disk before it leaves";
  EXPECT_EQ(v.state.durable.granted_to, std::optional(id(2)));
  EXPECT_EQ(ops(v.receive(2.2, 0, RoleOp::kPropose, 2, 0)), Ops{RoleOp::kRefuse});
  EXPECT_EQ(ops(v.receive(2.3, 2, RoleOp::kPropose, 2, 2)), Ops{RoleOp::kGrant})
      << "the first was lost";
  EXPECT_EQ(ops(v.receive(3.0, 0, RoleOp::kPropose, 3, 0)), Ops{RoleOp::kRefuse})
      << "v2 may be anchor by now";
  EXPECT_EQ(ops(v.receive(7.6, 0, RoleOp::kPropose, 3, 0)), Ops{RoleOp::kGrant});
}

TEST(RoleVote, requested_on_behalf_of_another_vehicle_is_refused) {
  Vehicle v(1);
  EXPECT_EQ(ops(v.receive(1.0, 2, RoleOp::kPropose, 1, 0)), Ops{RoleOp::kRefuse});
}

TEST(RoleVote, survives_a_restart_and_so_does_the_promise) {
  Vehicle v = tag_of_three();
  v.receive(2.0, 0, RoleOp::kSeal, 1);
  v.receive(2.1, 2, RoleOp::kPropose, 2, 2);
  Vehicle again(1, v.state.durable, 3.0);
  EXPECT_EQ(again.state.durable.term, 2U);
  EXPECT_EQ(ops(again.receive(3.1, 0, RoleOp::kPropose, 2, 0)), Ops{RoleOp::kRefuse});
  EXPECT_EQ(ops(again.receive(3.2, 0, RoleOp::kPropose, 3, 0)), Ops{RoleOp::kRefuse});
  EXPECT_EQ(ops(again.receive(3.0 + kPromise_s, 0, RoleOp::kPropose, 3, 0)), Ops{RoleOp::kGrant});
}

TEST(RoleVote, is_not_granted_while_the_saved_role_is_unconfirmed) {
  DurableRole unreadable = durable_of(3);
  unreadable.confirmed = false;
  Vehicle v(1, unreadable);
  EXPECT_EQ(ops(v.receive(10.0, 2, RoleOp::kPropose, 1, 2)), Ops{RoleOp::kRefuse});
  EXPECT_TRUE(has(v.give(11.0, RoleClaim{}), RoleActionKind::kRefused));
  EXPECT_TRUE(v.give(12.0, RoleConfirm{}).save);
  EXPECT_EQ(ops(v.receive(13.0, 2, RoleOp::kPropose, 1, 2)), Ops{RoleOp::kGrant});
}

TEST(RoleCandidate, commits_with_a_majority_of_the_fleet_not_of_the_replies) {
  DurableRole five = durable_of(5);
  Vehicle v(0, five);
  v.give(0.0, RoleClaim{});
  v.receive(0.1, 1, RoleOp::kGrant, 1, 0);
  v.receive(0.2, 1, RoleOp::kGrant, 1, 0);  // the same one twice
  v.receive(0.3, 2, RoleOp::kGrant, 9, 0);  // another term
  v.receive(0.3, 3, RoleOp::kGrant, 1, 4);  // for another
  v.receive(0.4, 7, RoleOp::kGrant, 1, 0);  // not in the fleet
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
  const RoleStep step = v.receive(0.5, 4, RoleOp::kGrant, 1, 0);
  EXPECT_EQ(v.state.mode, RoleMode::kAnchor);
  EXPECT_TRUE(has(step, RoleActionKind::kBecameAnchor));
  EXPECT_EQ(ops(step), Ops{RoleOp::kCommit});
  EXPECT_TRUE(may_publish(v.state, at(4.9)));
  EXPECT_FALSE(may_publish(v.state, at(5.0))) << "the lease counts from the question";
}

TEST(RoleCandidate, repeats_its_proposal_and_backs_off_after_two_leases) {
  Vehicle v(0);
  v.give(0.0, RoleClaim{});
  EXPECT_EQ(ops(v.tick(0.5)), Ops{});
  EXPECT_EQ(ops(v.tick(1.0)), Ops{RoleOp::kPropose});
  v.tick(9.9);
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
  v.tick(10.0);
  EXPECT_EQ(v.state.mode, RoleMode::kTag);
  EXPECT_GE(v.state.takeover_at, at(15.0));
  EXPECT_LE(v.state.takeover_at, at(25.0));
}

TEST(RoleCandidate, withdraws_when_it_moves_and_follows_a_received_commit) {
  Vehicle moved(0);
  moved.give(0.0, RoleClaim{});
  moved.give(1.0, RoleSelf{std::nullopt, 0});
  EXPECT_EQ(moved.state.mode, RoleMode::kTag);
  Vehicle late(0);
  late.give(0.0, RoleClaim{});
  const RoleStep step = late.receive(1.0, 2, RoleOp::kCommit, 2);
  EXPECT_EQ(late.state.mode, RoleMode::kTag);
  EXPECT_TRUE(has(step, RoleActionKind::kFollows));
  EXPECT_EQ(ops(step), Ops{RoleOp::kAck});
}

TEST(RoleAnchor, is_active_while_a_majority_acknowledges_and_then_stops_as_orphan) {
  Vehicle v = anchor_of_three();
  EXPECT_EQ(ops(v.tick(1.1)), Ops{RoleOp::kHeartbeat});
  EXPECT_EQ(v.receive(1.3, 2, RoleOp::kAck, 1, 0, 1.1).messages.size(), 0U);
  EXPECT_TRUE(may_publish(v.state, at(6.0)));
  EXPECT_FALSE(may_publish(v.state, at(6.1)));
  v.receive(2.0, 2, RoleOp::kAck, 1, 0, 50.0);  // of the clock before a restart
  v.receive(2.0, 2, RoleOp::kAck, 9, 0, 1.9);   // of another term
  const RoleStep step = v.tick(6.1);
  EXPECT_EQ(v.state.mode, RoleMode::kTag);
  EXPECT_TRUE(has(step, RoleActionKind::kStoppedAnchoring));
  EXPECT_TRUE(must_stand(v.state));
}

TEST(RoleAnchor, seals_when_all_that_are_present_have_finished) {
  Vehicle v = anchor_of_three();
  v.receive(1.0, 1, RoleOp::kAck, 1, 0, 0.9);
  v.receive(1.0, 2, RoleOp::kAck, 1, 0, 0.9);
  RoleMessage done;
  done.op = RoleOp::kFinished;
  done.term = 1;
  done.reason = FinishReason::kDistance;
  done.t_send = at(20.0);
  v.give(1.1, RoleReceived{id(1), done});
  v.tick(1.2);
  EXPECT_EQ(v.state.mode, RoleMode::kAnchor) << "v2 is on its way";
  done.t_send = at(30.0);
  v.give(1.3, RoleReceived{id(2), done});
  done.reason = FinishReason::kNone;
  done.t_send = at(29.0);  // an older message that arrived late
  v.give(1.4, RoleReceived{id(2), done});
  const RoleStep step = v.tick(1.5);
  EXPECT_EQ(v.state.mode, RoleMode::kSealed);
  EXPECT_TRUE(has(step, RoleActionKind::kSealed));
  EXPECT_EQ(ops(step), Ops{RoleOp::kSeal});
  EXPECT_FALSE(may_publish(v.state, at(1.5)));
}

TEST(RoleAnchor, that_is_pushed_seals_at_once) {
  Vehicle v = anchor_of_three();
  const RoleStep step = v.give(1.0, RoleSelf{std::nullopt, 0});
  EXPECT_EQ(v.state.mode, RoleMode::kSealed);
  EXPECT_EQ(ops(step), Ops{RoleOp::kSeal});
}

TEST(RoleAnchor, renews_its_term_in_the_same_round_after_a_failed_election) {
  Vehicle v = anchor_of_three();
  RoleStep step = v.receive(1.0, 2, RoleOp::kRefuse, 4, 0);
  EXPECT_EQ(v.state.durable.term, 5U);
  EXPECT_EQ(ops(step), Ops{RoleOp::kPropose});
  EXPECT_FALSE(may_publish(v.state, at(1.0)));
  step = v.receive(1.1, 1, RoleOp::kGrant, 5, 0, 1.0);
  EXPECT_TRUE(has(step, RoleActionKind::kRenewedTerm));
  EXPECT_FALSE(has(step, RoleActionKind::kBecameAnchor));
  // The tag observes the same round.
  Vehicle tag = tag_of_three();
  tag.give(0.5, RoleFinished{FinishReason::kSignal});
  EXPECT_EQ(ops(tag.receive(1.0, 0, RoleOp::kPropose, 5, 0)), Ops{RoleOp::kGrant});
  EXPECT_FALSE(has(tag.receive(1.2, 0, RoleOp::kCommit, 5), RoleActionKind::kFollows));
  EXPECT_EQ(tag.state.finished, FinishReason::kSignal);
}

TEST(RoleSealed, offers_the_role_to_candidates_by_rank_and_finally_to_itself) {
  Vehicle v = anchor_of_three();
  v.give(1.0, RoleEndRound{});
  v.give(1.5, RoleChoice{{id(2), id(1)}});
  RoleStep step = v.tick(2.0);
  ASSERT_EQ(ops(step), (Ops{RoleOp::kSeal, RoleOp::kHandover}));
  EXPECT_EQ(step.messages[1].to, std::optional(id(2)));
  EXPECT_EQ(step.messages[1].message.term, 2U);
  step = v.tick(16.5);  // 3 L later
  ASSERT_EQ(ops(step), (Ops{RoleOp::kSeal, RoleOp::kHandover}));
  EXPECT_EQ(step.messages[1].to, std::optional(id(1)));
  EXPECT_EQ(step.messages[1].message.term, 3U);
  step = v.tick(31.5);
  EXPECT_EQ(v.state.mode, RoleMode::kCandidate);
  EXPECT_EQ(v.state.durable.term, 4U);
}

TEST(RoleSealed, votes_for_its_successor_and_stands_until_ten_ranges_are_received) {
  Vehicle v = anchor_of_three();
  v.give(1.0, RoleEndRound{});
  v.give(1.1, RoleChoice{{id(2)}});
  EXPECT_EQ(ops(v.receive(2.0, 2, RoleOp::kPropose, 2, 2)), Ops{RoleOp::kGrant});
  v.receive(2.5, 2, RoleOp::kCommit, 2);
  EXPECT_TRUE(must_stand(v.state));
  v.give(3.0, RoleSelf{at(-100.0), 9});
  EXPECT_TRUE(must_stand(v.state));
  EXPECT_TRUE(has(v.give(3.1, RoleSelf{at(-100.0), 10}), RoleActionKind::kMayLeave));
  EXPECT_FALSE(must_stand(v.state));
}

}  // namespace
}  // namespace rali::fleet
