// Solutions of the map run beside the steps of a node.
#include <gtest/gtest.h>

#include "rali/fleet/node/node_fleet_for_test.hpp"

namespace rali::fleet {
namespace {

/// Longer than a lease (5 s), as with four vehicles in a kilometre of tunnel.
constexpr double kLongSolve_s = 6.0;

Fleet with_anchor(double solve_s, bool in_step = false) {
  Fleet fleet(2);
  fleet.solve_s = solve_s;
  fleet.solves_in_step = in_step;
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  fleet.run(4.0);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(fleet.jobs.size(), solve_s > 0.0 ? 1U : 0U) << "it solves for its first map";
  return fleet;
}

Increment next_step() {
  Increment step;
  step.node = 1;
  step.keyframe = 1;
  step.T_odom_body.p = {1.0, 0.0, 0.0};
  step.levelled = true;
  step.covariance = geometry::Mat6::Identity() * 1e-6;
  step.lidar_information = geometry::Mat6::Identity() * 1e6;
  return step;
}

TEST(NodeJobs, an_anchor_that_solves_inside_its_step_loses_its_lease) {
  Fleet fleet = with_anchor(kLongSolve_s, true);
  fleet.run(kLongSolve_s + 1.0);
  EXPECT_TRUE(fleet.did(0, RoleActionKind::kOrphaned));
}

TEST(NodeJobs, an_anchor_that_solves_in_a_background_job_keeps_its_lease) {
  Fleet fleet = with_anchor(kLongSolve_s);
  fleet.run(60.0);
  EXPECT_FALSE(fleet.did(0, RoleActionKind::kOrphaned));
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(fleet.nodes[0].term(), 1U);
  ASSERT_TRUE(fleet.nodes[1].T_map_odom()) << "the table has come";
  EXPECT_NEAR(fleet.nodes[1].T_map_odom()->p.x(), 2.0, 1e-3);
}

TEST(NodeJobs, one_job_runs_at_a_time_and_the_next_includes_newer_facts) {
  Fleet fleet = with_anchor(kLongSolve_s);
  fleet.run(3.0);
  EXPECT_EQ(fleet.jobs.size(), 1U);
  EXPECT_TRUE(fleet.nodes[0].mapper()->is_solving());
  fleet.fact(1, next_step());
  fleet.run(5.0);
  EXPECT_EQ(fleet.nodes[1].map_poses().size(), 2U) << "told of what was there at its begin";
  fleet.run(12.0);
  EXPECT_EQ(fleet.nodes[1].map_poses().size(), 3U);
}

// Over a bad radio they come just after the anchor's first estimate. Until the next one a vehicle
// drives by its start pose alone, which may be degrees off.
TEST(NodeJobs, early_facts_are_in_the_map_within_seconds) {
  Fleet fleet = with_anchor(0.0);
  fleet.run(1.0);
  ASSERT_EQ(fleet.nodes[1].map_poses().size(), 2U);
  fleet.fact(1, next_step());
  fleet.run(3.0);
  EXPECT_EQ(fleet.nodes[1].map_poses().size(), 3U);
}

TEST(NodeJobs, a_frontier_search_is_a_job_and_searches_do_not_overlap) {
  Fleet fleet = with_anchor(0.0);
  fleet.search_s = 4.5;  // more than two periods
  fleet.run(5.0);        // those requested before
  std::vector<std::uint64_t> numbers;
  for (int k = 0; k < 200; ++k) {
    fleet.step(0.1);
    ASSERT_LE(fleet.searches.size(), 1U);
    if (fleet.searches.empty()) continue;
    EXPECT_EQ(fleet.searches.front().kind, JobKind::kExplore);
    const std::uint64_t number = fleet.searches.front().done.number;
    if (numbers.empty() || numbers.back() != number) numbers.push_back(number);
  }
  EXPECT_GE(numbers.size(), 4U);
  EXPECT_LE(numbers.size(), 6U) << "20 s";
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
}

TEST(NodeJobs, a_sealed_round_ends_only_after_the_search_for_the_next_anchor) {
  Fleet fleet = with_anchor(0.0);
  fleet.search_s = 20.0;
  fleet.run(3.0);
  receive_weakly(fleet);
  while (fleet.nodes[0].mode() == Mode::kAnchor && fleet.now < Time::from_s(160.0)) fleet.step(0.1);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kSealed);
  fleet.run(1.0);
  ASSERT_EQ(fleet.searches.size(), 1U) << "the one before was given up";
  EXPECT_EQ(fleet.searches.front().kind, JobKind::kNextAnchor);
  EXPECT_EQ(fleet.nodes[0].rounds().rounds().back().ended_by, RoundEnd::kOpen);
  fleet.run(20.0);
  EXPECT_EQ(fleet.nodes[0].rounds().rounds().front().ended_by, RoundEnd::kFinished);
  fleet.run(20.0);
  EXPECT_GE(fleet.nodes[0].term(), 2U);
}

TEST(NodeJobs, a_result_with_an_unknown_number_is_ignored) {
  Fleet fleet = with_anchor(kLongSolve_s);
  const std::uint64_t number = fleet.jobs.front().done.number;
  fleet.give(0, JobDone{number + 1, fleet.jobs.front().done.job});
  fleet.give(0, JobDone{number + 2, nullptr});
  fleet.give(1, JobDone{number, nullptr});
  EXPECT_TRUE(fleet.nodes[0].mapper()->is_solving());
  EXPECT_FALSE(fleet.nodes[1].T_map_odom());
  fleet.run(kLongSolve_s + 0.5);
  EXPECT_TRUE(fleet.nodes[1].T_map_odom());
  fleet.give(0, JobDone{number, nullptr});  // once more
  fleet.run(30.0);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
}

TEST(NodeJobs, sealing_cancels_the_running_job_and_solves_the_round_once_more) {
  Fleet fleet = with_anchor(kLongSolve_s);
  fleet.run(7.0);
  receive_weakly(fleet);
  while (fleet.nodes[0].mode() == Mode::kAnchor && fleet.now < Time::from_s(160.0)) fleet.step(0.1);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kSealed);
  fleet.run(0.2);
  ASSERT_EQ(fleet.jobs.size(), 1U);
  EXPECT_EQ(fleet.jobs.front().kind, JobKind::kEndRound);
  EXPECT_EQ(fleet.nodes[0].rounds().rounds().back().ended_by, RoundEnd::kOpen);
  fleet.run(kLongSolve_s);
  const RoundRow round = fleet.nodes[0].rounds().rounds().front();
  EXPECT_EQ(round.ended_by, RoundEnd::kFinished);
  fleet.run(30.0);
  EXPECT_GE(fleet.nodes[0].term(), 2U);
  EXPECT_FALSE(fleet.did(0, RoleActionKind::kOrphaned));
}

// The role machine waits 30 s for a choice. With a slower solution the anchor followed itself,
// however much better another vehicle was.
TEST(NodeJobs, the_hand_over_waits_for_the_last_solution_of_the_round) {
  Fleet fleet = with_anchor(0.0);
  fleet.solve_s = 80.0;
  receive_weakly(fleet);
  while (fleet.nodes[0].mode() == Mode::kAnchor && fleet.now < Time::from_s(160.0)) fleet.step(0.1);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kSealed);
  fleet.run(75.0);
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kSealed);
  EXPECT_EQ(fleet.nodes[1].term(), 1U) << "nobody else took over either";
  const std::size_t rounds = fleet.nodes[0].rounds().rounds().size();
  fleet.run(10.0);
  EXPECT_NE(fleet.nodes[0].rounds().rounds()[rounds - 1].ended_by, RoundEnd::kOpen);
}

/// A candidate of a higher term was lost: the anchor takes a new term and the round continues.
void raise_term(Fleet& fleet) {
  RoleMessage refusal;
  refusal.op = RoleOp::kRefuse;
  refusal.term = fleet.nodes[0].term() + 3;
  refusal.candidate = id(0);
  refusal.t_send = fleet.now;
  fleet.give(0, Envelope{id(1), id(0), refusal});
}

TEST(NodeJobs, a_solution_of_an_earlier_term_is_dropped_and_repeated) {
  Fleet fleet = with_anchor(kLongSolve_s);
  const std::uint64_t number = fleet.jobs.front().done.number;
  raise_term(fleet);
  ASSERT_EQ(fleet.cancelled.size(), 1U) << "it stopped to be the anchor of that term";
  EXPECT_EQ(fleet.cancelled.front(), number);
  fleet.run(1.0);
  ASSERT_EQ(fleet.nodes[0].mode(), Mode::kAnchor);
  EXPECT_EQ(fleet.nodes[0].term(), 5U);
  EXPECT_FALSE(fleet.nodes[1].T_map_odom()) << "nothing of the first one was told";
  ASSERT_EQ(fleet.jobs.size(), 1U);
  EXPECT_GT(fleet.jobs.front().done.number, number);
  fleet.run(kLongSolve_s);
  EXPECT_TRUE(fleet.nodes[1].T_map_odom());
}

TEST(NodeJobs, a_former_anchor_cancels_its_job_and_broadcasts_no_table) {
  Fleet fleet = with_anchor(kLongSolve_s);
  RoleMessage commit;
  commit.op = RoleOp::kCommit;
  commit.term = fleet.nodes[0].term() + 1;
  commit.candidate = id(1);
  fleet.silent.insert(1);
  fleet.give(0, Envelope{id(1), id(0), commit});
  EXPECT_EQ(fleet.nodes[0].mode(), Mode::kHolding);
  EXPECT_EQ(fleet.cancelled.size(), 1U);
  fleet.air.clear();
  fleet.step(0.1);
  EXPECT_TRUE(fleet.jobs.empty());
  for (const Envelope& e : fleet.air) EXPECT_FALSE(std::holds_alternative<Table>(e.message));
}

TEST(NodeJobs, a_lost_job_is_repeated_from_all_facts) {
  Fleet fleet = with_anchor(kLongSolve_s);
  const std::uint64_t number = fleet.jobs.front().done.number;
  fleet.jobs.clear();
  fleet.give(0, JobDone{number, nullptr});
  fleet.run(kLongSolve_s + 1.0);
  ASSERT_TRUE(fleet.nodes[1].T_map_odom());
  EXPECT_NEAR(fleet.nodes[1].T_map_odom()->p.x(), 2.0, 1e-3);
}

TEST(NodeJobs, a_job_that_never_ran_is_requested_again_with_the_same_facts) {
  Fleet fleet(2);
  for (std::size_t v = 0; v < 2; ++v) fleet.start(v);
  NodeOutputs out;
  std::optional<RunJob> order;
  while (!order && fleet.now < Time::from_s(110.0)) {
    fleet.now = fleet.now + Duration::from_s(0.1);
    out.clear();
    OwnPose pose;
    pose.t = fleet.now;
    pose.at_rest = pose.levelled = true;
    fleet.nodes[0].step(pose, fleet.now, out);
    fleet.nodes[0].step(NodeTick{}, fleet.now, out);
    for (const NodeOutput& o : out) {
      if (const auto* e = std::get_if<Envelope>(&o)) fleet.give(1, *e);
      const auto* job = std::get_if<RunJob>(&o);
      if (job != nullptr && !explores(job->kind)) order = *job;
    }
    for (const Envelope& e : std::exchange(fleet.air, {})) fleet.nodes[0].step(e, fleet.now, out);
  }
  ASSERT_TRUE(order);
  fleet.give(0, JobDone{order->number, order->job});
  fleet.run(15.0);
  ASSERT_TRUE(fleet.nodes[1].T_map_odom());
}

}  // namespace
}  // namespace rali::fleet
