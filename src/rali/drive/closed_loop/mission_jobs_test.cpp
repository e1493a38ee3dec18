// Missions on computers with slow map solutions: tables are late, with no other effect.
#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/closed_loop/missions_for_test.hpp"

namespace rali::drive {
namespace {

struct Flown {
  MissionLog log;
  bool finished = false;
  double duration_s = 0.0;
  std::size_t most_anchors = 0, orphaned = 0, lost = 0;
  std::uint64_t last_term = 0;
};

Flown fly(const Simulation& sim, const ComputerSettings& computer, const JobCost& cost) {
  ExactFleet fleet(*sim, without_loops(), computer, cost);
  Flown flown;
  const auto mission = sim::run_closed_loop(*sim, fleet, limited(900.0));
  EXPECT_TRUE(mission.has_value());
  flown.finished = mission->finished;
  flown.duration_s = mission->duration_s;
  flown.log = fleet.nodes().log();
  flown.most_anchors = fleet.most_anchors;
  for (const Finding& finding : fleet.nodes().take_findings()) {
    flown.orphaned += finding.text.starts_with("receives no anchor") ? 1 : 0;
    flown.lost += finding.id == "fleet.job_lost" ? 1 : 0;
  }
  for (const fleet::RoundRow& round : flown.log.rounds) {
    EXPECT_NE(round.ended_by, fleet::RoundEnd::kAnchorLost) << round.round;
  }
  flown.last_term = fleet.nodes().node(0).term();
  return flown;
}

/// Each job alone takes longer than a lease.
constexpr double kLong_s = 6.0;

TEST(MissionJobs, with_solutions_of_6_s_lose_no_lease_and_the_mission_ends) {
  const Flown flown = fly(three_rooms(), {}, {.job_s = kLong_s});
  EXPECT_TRUE(flown.finished);
  EXPECT_TRUE(flown.log.explored);
  EXPECT_EQ(flown.most_anchors, 1U);
  EXPECT_EQ(flown.orphaned, 0U);
  EXPECT_EQ(flown.last_term, flown.log.rounds.size()) << "each term is a round: none was renewed";
}

TEST(MissionJobs, on_a_ten_times_slower_computer_also_complete_the_mission) {
  const Flown measured = fly(three_rooms(), {}, {});
  const Flown slow = fly(three_rooms(), {.cpu_factor = 10.0}, {});
  for (const Flown* flown : {&measured, &slow}) {
    EXPECT_TRUE(flown->finished);
    EXPECT_TRUE(flown->log.explored);
    EXPECT_EQ(flown->most_anchors, 1U);
    EXPECT_EQ(flown->orphaned, 0U);
  }
  EXPECT_LT(slow.duration_s, 1.5 * measured.duration_s + 30.0);
}

// Reveals a step that draws, however fast the computer is.
TEST(MissionJobs, draw_all_grid_cells_and_produce_the_goals) {
  const Simulation sim = three_rooms();
  ExactFleet fleet(*sim, without_loops());
  std::size_t goal_lists = 0, compared = 0;
  fleet.on_output = [&](std::size_t, const fleet::NodeOutput& output) {
    const auto* envelope = std::get_if<fleet::Envelope>(&output);
    if (envelope != nullptr) {
      goal_lists += std::holds_alternative<fleet::GoalList>(envelope->message) ? 1 : 0;
    }
  };
  fleet.on_time = [&](Time) {
    std::size_t written = 0, drawn = 0;
    for (std::size_t v = 0; v < fleet.nodes().size(); ++v) {
      const fleet::Node& node = fleet.nodes().node(v);
      if (node.exploration() == nullptr) continue;
      if (node.exploration()->map() == nullptr) return;
      written += node.exploration()->map()->grid().cells_written();
    }
    for (const SimulatedJobs::Spent& job : fleet.nodes().jobs().spent()) {
      drawn += job.work.cells_drawn;
    }
    EXPECT_EQ(written, drawn);
    ++compared;
  };
  EXPECT_TRUE(sim::run_closed_loop(*sim, fleet, limited(60.0)).has_value());
  std::size_t explorations = 0;
  for (const SimulatedJobs::Spent& job : fleet.nodes().jobs().spent()) {
    explorations += fleet::explores(job.kind) ? 1 : 0;
  }
  EXPECT_GT(compared, 100U);
  EXPECT_GT(goal_lists, 5U);
  EXPECT_LE(goal_lists, explorations);
}

// The role machine waits 30 s for the choice of the next anchor. Here the anchor cannot be the next
// one: the tag has no path past it.
TEST(MissionJobs, a_hand_over_waits_for_a_solution_that_is_longer_than_six_leases) {
  const Flown flown = fly(narrow_corridor(), {.cpu_factor = 10.0}, {.job_s = 4.0});
  EXPECT_TRUE(flown.finished);
  EXPECT_TRUE(flown.log.explored);
  ASSERT_GE(flown.log.rounds.size(), 2U);
  EXPECT_EQ(flown.log.rounds[0].anchor, VehicleId{0});
  EXPECT_EQ(flown.log.rounds[1].anchor, VehicleId{1});
  EXPECT_EQ(flown.orphaned, 0U);
}

TEST(MissionJobs, same_world_and_computer_give_the_same_rounds) {
  const auto run = [] {
    const Simulation sim = three_rooms();
    ExactFleet fleet(*sim, without_loops(), {.cpu_factor = 100.0});
    EXPECT_TRUE(sim::run_closed_loop(*sim, fleet, limited(30.0)).has_value());
    std::vector<double> paths;
    for (int v = 0; v < 3; ++v) paths.push_back(sim->path_m(v));
    return std::pair(fleet.nodes().log().rounds, paths);
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace rali::drive
