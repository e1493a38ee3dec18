#include "rali/fleet/node/fleet_mapper.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/centre/rounds_for_test.hpp"

namespace rali::fleet {
namespace {

NodeSettings by_rounds() {
  NodeSettings settings;
  settings.fleet = exact_rounds();
  return settings;
}

void run(Job& job, bool cancelled = false) {
  SerialExecutor executor;
  const std::atomic<bool> cancel = cancelled;
  job.run(executor, cancel);
}

/// A fleet mapper of a round of three vehicles, and another anchor's result of the same facts.
struct Begin {
  Begin() : mapper(by_rounds(), fleet.knowledge()), other(exact_rounds(), fleet.knowledge()) {
    for (const Fact& fact : fleet.round()) {
      mapper.add(std::make_shared<const Fact>(fact));
      other.add(fact);
    }
    SerialExecutor executor;
    other.end_round(fleet.now(), executor);
  }

  FleetForTest fleet{RoundsForTest{}};
  FleetMapper mapper;
  RoundCentre other;
};

TEST(FleetMapper, a_job_returns_the_same_estimate_as_a_direct_solution) {
  Begin begin;
  const auto job = begin.mapper.make_job(begin.fleet.now());
  EXPECT_TRUE(begin.mapper.is_solving());
  EXPECT_FALSE(begin.mapper.is_placed(VehicleId{1}));
  run(*job);
  EXPECT_GT(job->work().nodes, 50U);
  EXPECT_EQ(begin.mapper.take_back(job.get(), true), JobOutcome::kTaken);
  EXPECT_FALSE(begin.mapper.is_solving());
  EXPECT_TRUE(begin.mapper.is_placed(VehicleId{1}));
  ASSERT_TRUE(begin.mapper.separator());
  ASSERT_EQ(begin.mapper.last().keyframes.size(), begin.other.last().keyframes.size());
  for (const auto& [id, pose] : begin.other.last().keyframes) {
    const geometry::SE3& T = begin.mapper.last().keyframes.at(id).T_map_body;
    EXPECT_EQ(geometry::boxminus(T, pose.T_map_body).norm(), 0.0);
  }
}

TEST(FleetMapper, facts_received_during_a_job_count_from_the_next_job) {
  Begin begin;
  const auto first = begin.mapper.make_job(std::nullopt);
  run(*first);
  for (const Fact& fact : begin.fleet.round()) {
    begin.mapper.add(std::make_shared<const Fact>(fact));
  }
  ASSERT_EQ(begin.mapper.take_back(first.get(), true), JobOutcome::kTaken);
  const std::size_t keyframes = begin.mapper.last().keyframes.size();
  const auto second = begin.mapper.make_job(std::nullopt);
  run(*second);
  ASSERT_EQ(begin.mapper.take_back(second.get(), true), JobOutcome::kTaken);
  EXPECT_GT(begin.mapper.last().keyframes.size(), keyframes + 10U);
}

TEST(FleetMapper, drops_a_result_if_other_frames_were_taken_over_meanwhile) {
  Begin begin;
  const auto job = begin.mapper.make_job(std::nullopt);
  run(*job);
  ASSERT_TRUE(begin.mapper.take_over(*begin.other.separator(), begin.other.last().keyframes));
  EXPECT_TRUE(begin.mapper.is_placed(VehicleId{2})) << "at once: nothing had to be solved";
  const geometry::SE3 T = *begin.mapper.T_map_odom({VehicleId{2}, 0});
  EXPECT_EQ(begin.mapper.take_back(job.get(), true), JobOutcome::kDropped);
  EXPECT_EQ(geometry::boxminus(T, *begin.mapper.T_map_odom({VehicleId{2}, 0})).norm(), 0.0);
  const auto next = begin.mapper.make_job(std::nullopt);
  run(*next);
  EXPECT_EQ(begin.mapper.take_back(next.get(), true), JobOutcome::kTaken);
  EXPECT_EQ(begin.mapper.work().rounds, 1U) << "on the boundary that was taken over";
}

TEST(FleetMapper, an_unwanted_or_cancelled_job_changes_nothing_and_can_be_repeated) {
  for (const bool cancelled : {false, true}) {
    Begin begin;
    const auto job = begin.mapper.make_job(std::nullopt);
    run(*job, cancelled);
    EXPECT_EQ(begin.mapper.take_back(job.get(), cancelled), JobOutcome::kDropped);
    EXPECT_FALSE(begin.mapper.is_placed(VehicleId{1}));
    const auto again = begin.mapper.make_job(std::nullopt);
    run(*again);
    EXPECT_EQ(begin.mapper.take_back(again.get(), true), JobOutcome::kTaken);
    EXPECT_TRUE(begin.mapper.is_placed(VehicleId{1}));
  }
}

TEST(FleetMapper, after_a_lost_job_the_mapper_is_rebuilt_from_all_facts) {
  Begin begin;
  const auto job = begin.mapper.make_job(std::nullopt);
  EXPECT_EQ(begin.mapper.take_back(nullptr, true), JobOutcome::kLost);
  EXPECT_TRUE(begin.mapper.is_solving());
  FleetForTest same{RoundsForTest{}};
  std::vector<FactPtr> facts;
  for (const Fact& fact : same.round()) facts.push_back(std::make_shared<const Fact>(fact));
  begin.mapper.restore(std::move(facts));
  const auto again = begin.mapper.make_job(std::nullopt);
  run(*again);
  EXPECT_EQ(begin.mapper.take_back(again.get(), true), JobOutcome::kTaken);
  EXPECT_TRUE(begin.mapper.is_placed(VehicleId{1}));
}

}  // namespace
}  // namespace rali::fleet
