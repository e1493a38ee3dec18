#include "rali/fleet/node/exploration.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::Vec2;

constexpr VehicleId kAnchor{0}, kTag{1};

void run(Job& job, bool cancelled = false) {
  SerialExecutor executor;
  const std::atomic<bool> cancel = cancelled;
  job.run(executor, cancel);
}

/// Ground up to 8 m around a body 0.5 m above it, scanned in rings.
KeyframePoints ground_around(std::uint32_t keyframe) {
  KeyframePoints points;
  PointArrays arrays;
  points.keyframe = keyframe;
  for (int ring = 0; ring < 40; ++ring) {
    for (int ray = 0; ray < 720; ++ray) {
      const double turn = 2.0 * std::numbers::pi * (ray + 0.5) / 720.0, r_m = 0.4 + 0.2 * ring;
      arrays.push_back(static_cast<float>(r_m * std::cos(turn)),
                       static_cast<float>(r_m * std::sin(turn)), -0.5F);
    }
  }
  points.points = PackedPoints(arrays);
  return points;
}

/// A keyframe of a vehicle at x, with the ground observed there.
std::vector<FactPtr> keyframe(VehicleId vehicle, std::uint32_t number, double x_m) {
  const Time t = Time::from_s(10.0 + number);
  Increment step;
  step.node = step.keyframe.emplace(number);
  step.T_odom_body.p.x() = x_m;
  const auto fact = [&](std::uint32_t seq, FactBody body) {
    return std::make_shared<const Fact>(Fact{{vehicle, 0, seq}, t, std::move(body)});
  };
  return {fact(2 * number, step), fact(2 * number + 1, ground_around(number))};
}

/// All odom frames equal the map.
ExploreInput input(JobKind kind = JobKind::kExplore) {
  auto placed = std::make_shared<Placement>();
  ExploreInput in;
  for (const VehicleId v : {kAnchor, kTag}) {
    placed->T_map_odom[{v, 0}] = {};
    in.fleet.push_back({v, Vec2::Zero(), true, v == kAnchor});
  }
  in.fleet[1].place_map_m = Vec2(2.0, 0.0);
  in.kind = kind;
  in.placed = std::move(placed);
  in.self = kAnchor;
  in.now = Time::from_s(20.0);
  return in;
}

class ExplorationTest : public testing::Test {
 protected:
  ExplorationTest() {
    for (const FactPtr& fact : keyframe(kAnchor, 0, 0.0)) exploration_.add(fact);
  }

  JobOutcome explore(bool wanted = true, bool cancelled = false) {
    const auto job = exploration_.make_job(input());
    run(*job, cancelled);
    return exploration_.take_back(job.get(), wanted);
  }

  Exploration exploration_{NodeSettings{}};
};

TEST_F(ExplorationTest, a_job_updates_the_grid_finds_frontiers_and_sends_free_vehicles) {
  const auto job = exploration_.make_job(input());
  EXPECT_EQ(exploration_.map(), nullptr) << "the job has it";
  run(*job);
  EXPECT_TRUE(exploration_.dispatcher().frontiers().empty()) << "nothing changes before it is back";
  ASSERT_EQ(exploration_.take_back(job.get(), true), JobOutcome::kTaken);
  EXPECT_EQ(job->work().cells_drawn, exploration_.map()->grid().cells_written());
  EXPECT_GT(job->work().cells_searched, 1000U);
  ASSERT_TRUE(exploration_.result().mapped);
  EXPECT_FALSE(exploration_.dispatcher().frontiers().empty());
  ASSERT_FALSE(exploration_.result().goals.goals.empty());
  for (const Goal& goal : exploration_.result().goals.goals) EXPECT_EQ(goal.vehicle, kTag);
}

TEST_F(ExplorationTest, an_unwanted_or_cancelled_job_assigns_no_goals) {
  EXPECT_EQ(explore(false), JobOutcome::kDropped);
  EXPECT_EQ(explore(true, true), JobOutcome::kDropped);
  EXPECT_TRUE(exploration_.dispatcher().frontiers().empty());
  EXPECT_TRUE(exploration_.result().goals.goals.empty());
  EXPECT_EQ(explore(), JobOutcome::kTaken) << "the grid and its facts are here again";
  EXPECT_FALSE(exploration_.result().goals.goals.empty());
}

TEST_F(ExplorationTest, facts_received_during_a_job_enter_the_grid_in_the_next_job) {
  const auto first = exploration_.make_job(input());
  for (const FactPtr& fact : keyframe(kTag, 0, 2.0)) exploration_.add(fact);
  run(*first);
  ASSERT_EQ(exploration_.take_back(first.get(), true), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.map()->grid().keyframes(), 1U);
  EXPECT_EQ(explore(), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.map()->grid().keyframes(), 2U);
}

TEST_F(ExplorationTest, a_job_that_never_ran_leaves_its_facts_to_the_next_one) {
  const auto job = exploration_.make_job(input());
  EXPECT_EQ(exploration_.take_back(job.get(), true), JobOutcome::kDropped);
  EXPECT_EQ(explore(), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.map()->grid().keyframes(), 1U);
}

TEST_F(ExplorationTest, after_a_lost_job_the_grid_is_rebuilt_from_restored_facts) {
  static_cast<void>(exploration_.make_job(input()));
  EXPECT_EQ(exploration_.take_back(nullptr, true), JobOutcome::kLost);
  exploration_.restore(keyframe(kAnchor, 0, 0.0));
  EXPECT_EQ(explore(), JobOutcome::kTaken);
  EXPECT_TRUE(exploration_.result().mapped);
}

TEST_F(ExplorationTest, a_keyframe_without_a_pose_is_removed_from_the_grid_until_placed) {
  ASSERT_EQ(explore(), JobOutcome::kTaken);
  ExploreInput apart = input();
  apart.placed = std::make_shared<const Placement>();
  const auto job = exploration_.make_job(apart);
  run(*job);
  ASSERT_EQ(exploration_.take_back(job.get(), true), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.map()->grid().keyframes(), 0U);
  ASSERT_EQ(explore(), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.map()->grid().keyframes(), 1U);
}

TEST_F(ExplorationTest, the_last_search_of_a_round_ranks_anchors_without_assigning_goals) {
  ExploreInput last = input(JobKind::kNextAnchor);
  last.progress_since = Time::from_s(0.0);
  const auto job = exploration_.make_job(last);
  run(*job);
  ASSERT_EQ(exploration_.take_back(job.get(), true), JobOutcome::kTaken);
  EXPECT_EQ(exploration_.result().next_anchors.size(), 2U);
  EXPECT_TRUE(exploration_.result().progress);
  EXPECT_TRUE(exploration_.result().goals.goals.empty());
  EXPECT_FALSE(exploration_.result().goals.frontiers.empty());
}

// Nav2 reports that it gave up, not that another vehicle was in the way. Taken for a path that does
// not exist, the frontier behind the other was never tried again.
TEST_F(ExplorationTest, a_drive_given_up_beside_another_vehicle_is_tried_again_in_the_next_round) {
  for (const double place_m : {1.5, 5.0}) {
    Exploration exploration{NodeSettings{}};
    for (const FactPtr& fact : keyframe(kAnchor, 0, 0.0)) exploration.add(fact);
    ExploreInput in = input();
    in.fleet[1].place_map_m.x() = place_m;
    in.fleet[1].at_rest = true;
    const auto goals = [&] {
      const auto job = exploration.make_job(in);
      run(*job);
      EXPECT_EQ(exploration.take_back(job.get(), true), JobOutcome::kTaken);
      return exploration.result().goals.goals;
    };
    std::vector<Goal> assigned = goals();
    ASSERT_FALSE(assigned.empty());
    for (int k = 0; k < 2 && !assigned.empty(); ++k) {  // past the anchor, then straight
      in.fleet[1].drive_end = DriveEnd{DriveState::kGivenUp, assigned.back().place_map_m};
      assigned = goals();
    }
    EXPECT_TRUE(assigned.empty()) << place_m;
    exploration.new_round();
    in.fleet[1].drive_end.reset();
    EXPECT_EQ(goals().empty(), place_m > 2.0) << place_m;
  }
}

TEST_F(ExplorationTest, without_progress_reports_what_blocks_each_frontier) {
  ExploreInput last = input(JobKind::kNextAnchor);
  last.progress_since = Time::from_s(15.0);  // after the only keyframe
  const auto job = exploration_.make_job(last);
  run(*job);
  ASSERT_EQ(exploration_.take_back(job.get(), true), JobOutcome::kTaken);
  EXPECT_FALSE(exploration_.result().progress);
  EXPECT_TRUE(exploration_.result().next_anchors.empty());
  EXPECT_EQ(exploration_.result().stops.size(), exploration_.result().goals.frontiers.size());
}

}  // namespace
}  // namespace rali::fleet
