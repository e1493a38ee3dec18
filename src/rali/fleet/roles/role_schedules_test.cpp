// A thousand random schedules of the role machine, with clocks of different rates.
#include "rali/fleet/roles/role_fleet_for_test.hpp"

namespace rali::fleet {
namespace {

using test::id;
using test::RoleFleetSim;

struct Tally {
  int conflicts = 0, overlaps = 0, two_in_a_term = 0, without_anchor = 0;
  double commits = 0.0, longest_wait_s = 0.0;
};

void disturb(RoleFleetSim& sim) {
  const int n = sim.size();
  const auto any = [&] { return static_cast<int>(sim.rng().below(static_cast<std::uint64_t>(n))); };
  const double dice = sim.rng().uniform();
  if (dice < 0.01) sim.kill(any());
  if (dice >= 0.01 && dice < 0.04) {
    const int v = any();
    if (!sim.node(v).alive) sim.restart(v);
  }
  if (dice >= 0.04 && dice < 0.05) sim.restart(any());
  if (dice >= 0.05 && dice < 0.06) sim.node(any()).side = 1;
  if (dice >= 0.06 && dice < 0.08) sim.node(any()).side = 0;
  if (dice >= 0.08 && dice < 0.12) sim.give(any(), RoleFinished{FinishReason::kDistance});
  if (dice >= 0.12 && dice < 0.13) sim.give(any(), RoleEndRound{});
  if (dice >= 0.13 && dice < 0.14) sim.give(any(), RoleSelf{std::nullopt, 0});
  if (dice >= 0.14 && dice < 0.18) {
    const int v = any();
    sim.give(v, RoleSelf{sim.clock(v) - Duration::from_s(10.0), 0});
  }
  if (dice >= 0.18 && dice < 0.19) sim.give(any(), RoleClaim{});
}

void heal(RoleFleetSim& sim) {
  sim.radio = {};
  for (int v = 0; v < sim.size(); ++v) {
    sim.node(v).side = 0;
    if (!sim.node(v).alive) sim.restart(v);
    sim.give(v, RoleSelf{sim.clock(v) - Duration::from_s(10.0), 0});
  }
}

Tally schedules(int n, std::uint64_t first, std::uint64_t count) {
  Tally tally;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    RoleFleetSim sim(n, seed);
    sim.radio = {0.2, 0.1, seed % 4 == 0 ? 8.0 : 1.0};
    sim.give(0, RoleClaim{});
    for (int k = 0; k < 300; ++k) {
      disturb(sim);
      sim.advance(sim.rng().uniform(0.2, 1.0));
    }
    heal(sim);
    const double healed_s = sim.now_s();
    while (!sim.acting_anchor() && sim.now_s() - healed_s < 60.0) sim.advance(0.5);
    tally.longest_wait_s = std::max(tally.longest_wait_s, sim.now_s() - healed_s);
    tally.without_anchor += sim.acting_anchor() ? 0 : 1;
    tally.conflicts += sim.conflicts;
    tally.overlaps += sim.overlaps;
    tally.two_in_a_term += sim.two_in_a_term;
    tally.commits += static_cast<double>(sim.commits.size());
  }
  return tally;
}

void expect_order(const Tally& tally, double schedules) {
  EXPECT_EQ(tally.two_in_a_term, 0);
  EXPECT_EQ(tally.overlaps, 0);
  EXPECT_EQ(tally.conflicts, 0);
  EXPECT_EQ(tally.without_anchor, 0);
  EXPECT_GT(tally.commits, schedules) << "the schedules must make anchors, else they prove nothing";
  ::testing::Test::RecordProperty("longest_wait_s", std::to_string(tally.longest_wait_s));
  EXPECT_LT(tally.longest_wait_s, 45.0);
}

TEST(RoleSchedules, of_two_vehicles_never_have_two_anchors) {
  expect_order(schedules(2, 1000, 200), 200);
}

TEST(RoleSchedules, of_three_vehicles_never_have_two_anchors) {
  expect_order(schedules(3, 2000, 350), 350);
}

TEST(RoleSchedules, of_four_vehicles_never_have_two_anchors) {
  expect_order(schedules(4, 3000, 250), 250);
}

TEST(RoleSchedules, of_five_vehicles_never_have_two_anchors) {
  expect_order(schedules(5, 4000, 200), 200);
}

/// Tests the checker itself: with leases longer than the promises (clocks 20 % apart, 0 %
/// configured) it must find two anchors at one time, else the tests above prove nothing.
TEST(RoleSchedules, the_checker_detects_two_anchors_if_clock_rates_exceed_their_bound) {
  int overlaps = 0;
  for (std::uint64_t seed = 0; seed < 40 && overlaps == 0; ++seed) {
    RoleFleetSim sim(3, seed);
    sim.give(0, RoleClaim{});
    sim.run(3.0);
    sim.node(0).rate = 0.2;
    sim.node(0).offset_s += 0.8 * sim.now_s();
    sim.node(0).side = 1;
    sim.run(30.0);
    overlaps += sim.overlaps;
  }
  EXPECT_GT(overlaps, 0);
}

}  // namespace
}  // namespace rali::fleet
