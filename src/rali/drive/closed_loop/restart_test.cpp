// Vehicles that die at any event of a mission, lose what their logs had not synced, and restart
// from the rest. Odometry and rays are exact: only the fleet's promises are under test.
#include <cstdlib>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/closed_loop/missions_for_test.hpp"
#include "rali/drive/closed_loop/promises_for_test.hpp"

namespace rali::drive {
namespace {

/// Kills vehicles at random outputs of their nodes, in the middle of an event, and restarts them
/// half a second to some seconds later.
struct Restarts {
  Restarts(ExactFleet& killed, Time begin, std::uint64_t seed, std::size_t maximum, double between)
      : fleet(killed), rng(seed, "restart"), limit(maximum), outputs_between(between), now(begin) {
    next = later();
    fleet.on_output = [this](std::size_t v, const fleet::NodeOutput& output) { on(v, output); };
    fleet.on_time = [this](Time t) { on(t); };
  }

  [[nodiscard]] std::size_t later() {
    return outputs + 1 + static_cast<std::size_t>(rng.uniform() * outputs_between);
  }

  void on(std::size_t v, const fleet::NodeOutput& output) {
    if (++outputs >= next && count < limit && !dead) {
      // Before this output takes effect: only earlier outputs are saved or sent.
      next = later();
      ++count;
      dead = v;
      back_at = now + Duration::from_s(0.5 + 8.0 * rng.uniform());
      fleet.nodes().kill(v);
      return;
    }
    promises.on(v, output);
  }

  void on(Time t) {
    now = t;
    if (!dead || t < back_at) return;
    const Status started = fleet.restart(*dead, t);
    ASSERT_TRUE(started.has_value()) << started.error().message();
    const fleet::Node& node = fleet.nodes().node(*dead);
    epochs.insert({*dead, node.epoch()});
    facts_checked += promises.check_facts(*dead, node.store());
    dead.reset();
  }

  void check_at_end() {
    for (std::size_t v = 0; v < fleet.nodes().size(); ++v) {
      static_cast<void>(promises.check_facts(v, fleet.nodes().node(v).store()));
    }
    for (const std::string& broken : promises.broken) ADD_FAILURE() << broken;
    EXPECT_LE(fleet.most_anchors, 1U);
  }

  ExactFleet& fleet;
  Promises promises;
  Rng rng;
  std::size_t limit = 0;
  double outputs_between = 0.0;
  Time now, back_at;
  std::size_t outputs = 0, next = 0, count = 0, facts_checked = 0;
  std::optional<std::size_t> dead;
  std::set<std::pair<std::size_t, std::uint32_t>> epochs;
};

fleet::NodeSettings settings_of(double estimate_s) {
  fleet::NodeSettings settings;
  settings.fleet.loops.use = false;
  settings.estimate_s = estimate_s;
  return settings;
}

sim::ClosedLoopOptions limited(double time_limit_s) {
  sim::ClosedLoopOptions options;
  options.time_limit_s = time_limit_s;
  return options;
}

/// More for a long run: RALI_RESTART_SEEDS=200.
std::uint64_t seeds(std::uint64_t usual) {
  const char* given = std::getenv("RALI_RESTART_SEEDS");
  return given == nullptr ? usual : std::strtoull(given, nullptr, 10);
}

TEST(Restart, at_any_event_lets_the_mission_end_and_breaks_no_promise) {
  const std::uint64_t missions = seeds(10);
  std::size_t restarts = 0, explored = 0, facts = 0;
  for (std::uint64_t seed = 0; seed < missions; ++seed) {
    const Simulation sim = three_rooms();
    ExactFleet fleet(*sim, settings_of(10.0), true);
    Restarts r(fleet, sim->t_start(), seed, 1, 1000.0);
    const auto mission = sim::run_closed_loop(*sim, fleet, limited(900.0));
    ASSERT_TRUE(mission.has_value()) << mission.error().message();
    EXPECT_TRUE(mission->finished) << seed;
    r.check_at_end();
    restarts += r.epochs.size();
    facts += r.facts_checked;
    explored += fleet.nodes().log().explored ? 1 : 0;
  }
  EXPECT_GE(restarts, missions * 8 / 10) << "the others died with the end of the mission";
  EXPECT_GE(explored, missions * 9 / 10) << "a restarted vehicle finds its place by what it sees";
  EXPECT_GT(facts, 0U);
}

// A vehicle that restarts this often is not joined to a map, and need not be: estimates are rare,
// and only the promises between vehicles are checked.
TEST(Restart, two_hundred_times_breaks_no_promise) {
  std::size_t restarts = 0, votes = 0;
  for (std::uint64_t seed = 0; seed < 20 && restarts < 200; ++seed) {
    const Simulation sim = three_rooms();
    fleet::NodeSettings settings = settings_of(600.0);
    settings.fleet.loops.degenerate_tries = 0;
    settings.fleet.loops.scans_only_tries = 0;
    ExactFleet fleet(*sim, settings, true);
    Restarts r(fleet, sim->t_start(), 1000 + seed, 40, 200.0);
    const auto mission = sim::run_closed_loop(*sim, fleet, limited(500.0));
    ASSERT_TRUE(mission.has_value()) << mission.error().message();
    r.check_at_end();
    restarts += r.epochs.size();
    votes += r.promises.votes;
  }
  EXPECT_GE(restarts, 200U);
  EXPECT_GT(votes, 100U);
}

TEST(Restart, requires_a_dead_vehicle_with_a_log) {
  const Simulation sim = three_rooms();
  ExactFleet with(*sim, settings_of(10.0), true), without(*sim, settings_of(10.0));
  EXPECT_EQ(with.nodes().restart(0).error().code, ErrorCode::kUsage);
  without.nodes().kill(0);
  EXPECT_EQ(without.nodes().restart(0).error().code, ErrorCode::kUsage);
  with.nodes().kill(0);
  EXPECT_TRUE(with.nodes().restart(0).has_value());
  EXPECT_EQ(with.nodes().node(0).epoch(), 1U);
}

}  // namespace
}  // namespace rali::drive
