#include "rali/fleet/centre/round_centre.hpp"

#include <atomic>
#include <functional>

#include <gtest/gtest.h>

#include "rali/fleet/centre/rounds_for_test.hpp"
#include "rali/places/world_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::SE3;
using geometry::Vec3;

struct Both {
  FleetEstimate rounds, all;
  RoundCentre::Work work;
  Time last_round;
};

/// The same facts by rounds, and all at once.
Both by_rounds_and_at_once(const RoundsForTest& options, const FleetSettings& settings,
                           int rounds) {
  FleetForTest fleet(options);
  SerialExecutor executor;
  FleetSettings whole = settings;
  whole.solve = SolveWhat::kAll;
  RoundCentre centre(settings, fleet.knowledge());
  Centre at_once(whole, fleet.knowledge());
  Both both;
  for (int r = 0; r < rounds; ++r) {
    both.last_round = fleet.now();
    for (const Fact& fact : fleet.round()) {
      centre.add(fact);
      at_once.add(fact);
    }
    both.rounds = centre.end_round(fleet.now(), executor);
  }
  both.all = at_once.estimate(executor);
  both.work = centre.work();
  return both;
}

/// Heading and horizontal position. Tilt and height are relative to the level of the first vehicle:
/// all at once that is its first pose, by rounds the one where the round begins.
void expect_equal_covariance(const geometry::Mat6& round, const geometry::Mat6& all) {
  for (const int k : {2, 3, 4}) EXPECT_NEAR(round(k, k), all(k, k), 0.02 * all(k, k));
}

void expect_equal(const Both& both, double last_m) {
  ASSERT_EQ(both.all.groups.size(), 1U);
  ASSERT_EQ(both.rounds.keyframes.size(), both.all.keyframes.size());
  double moved_m = 0.0;
  for (const auto& [id, all] : both.all.keyframes) {
    const KeyframePose& round = both.rounds.keyframes.at(id);
    EXPECT_EQ(round.t, all.t);
    const geometry::Vec6 d = geometry::boxminus(round.T_map_body, all.T_map_body);
    if (all.t > both.last_round) {
      EXPECT_LT(d.norm(), last_m) << id.vehicle.value << " " << id.seq;
      expect_equal_covariance(round.covariance, all.covariance);
      continue;
    }
    moved_m = std::max(moved_m, d.tail<3>().norm());
    for (int k = 0; k < 6; ++k) {
      EXPECT_LT(std::abs(d[k]), 3.0 * std::sqrt(round.covariance(k, k)) + 1e-6) << id.seq;
    }
  }
  EXPECT_GT(moved_m, 1e-4) << "later rounds say nothing about earlier ones: nothing is tested";
}

TEST(RoundCentre, three_rounds_with_separator_priors_equal_one_batch_solution) {
  FleetSettings settings = exact_rounds();
  settings.joint.steps = StepWeight::kIsotropic;
  const Both both = by_rounds_and_at_once({}, settings, 3);
  EXPECT_EQ(both.work.whole, 1U);
  EXPECT_EQ(both.work.rounds, 2U);
  expect_equal(both, 1e-3);
}

TEST(RoundCentre, separator_priors_carry_velocities_and_biases_through_degenerate_rounds) {
  RoundsForTest options;
  options.degenerate = true;
  const Both both = by_rounds_and_at_once(options, exact_rounds(), 3);
  EXPECT_EQ(both.work.whole, 1U);
  expect_equal(both, 1e-3);
  ASSERT_EQ(both.rounds.biases.size(), both.all.biases.size());
  for (std::size_t k = 0; k < both.all.biases.size(); ++k) {
    EXPECT_NEAR(both.rounds.biases[k].bias_m, both.all.biases[k].bias_m, 2e-3);
    EXPECT_NEAR(both.rounds.biases[k].sigma_m, both.all.biases[k].sigma_m, 2e-3);
    EXPECT_EQ(both.rounds.biases[k].ranges, both.all.biases[k].ranges) << "each counted once";
  }
}

TEST(RoundCentre, intermediate_estimates_do_not_change_the_solution_at_the_round_end) {
  SerialExecutor executor;
  FleetForTest fleet({});
  RoundCentre once(exact_rounds(), fleet.knowledge()), often(exact_rounds(), fleet.knowledge());
  for (int r = 0; r < 2; ++r) {
    int n = 0;
    for (const Fact& fact : fleet.round()) {
      once.add(fact);
      often.add(fact);
      if (++n % 40 == 0 && often.paths().size() == 3) often.estimate(executor);
    }
    once.end_round(fleet.now(), executor);
    often.end_round(fleet.now(), executor);
  }
  for (const auto& [id, pose] : once.last().keyframes) {
    const SE3& other = often.last().keyframes.at(id).T_map_body;
    // Earlier frames are another linearisation, and give another sampling of ranges: microns.
    EXPECT_LT(geometry::boxminus(other, pose.T_map_body).norm(), 1e-4);
  }
}

TEST(RoundCentre, cost_per_round_stays_constant_over_60_rounds) {
  RoundsForTest options;
  options.to_and_fro = true;
  FleetForTest fleet(options);
  FleetSettings settings;
  settings.solve = SolveWhat::kRounds;
  settings.init.commit.information_min = 0.05;
  SerialExecutor executor;
  RoundCentre centre(settings, fleet.knowledge());
  std::size_t nodes = 0;
  Eigen::Index unknowns = 0;
  for (int r = 0; r < 60; ++r) {
    for (const Fact& fact : fleet.round()) centre.add(fact);
    const FleetEstimate& estimate = centre.end_round(fleet.now(), executor);
    ASSERT_TRUE(centre.separator());
    if (r == 2) {
      nodes = centre.work().nodes;
      unknowns = centre.separator()->unknowns();
    }
    if (r <= 2) continue;
    EXPECT_LE(centre.work().nodes, nodes + 3) << r;
    EXPECT_LE(centre.separator()->unknowns(), unknowns) << r;
    for (std::size_t v = 1; v < 3; ++v) {
      const KeyframePose& last =
          std::prev(estimate.keyframes.upper_bound({FleetForTest::id(v), 1000000U}))->second;
      const Vec3 error = last.T_map_body.p - fleet.p_m(v);
      EXPECT_LT(error.norm(), 1.0) << r;
    }
  }
  EXPECT_EQ(centre.work().whole, 1U);
  EXPECT_EQ(centre.work().rounds, 59U);
}

TEST(RoundCentre, taking_over_an_old_separator_prior_solves_only_the_rounds_since) {
  SerialExecutor executor;
  FleetForTest fleet({});
  RoundCentre first(exact_rounds(), fleet.knowledge()), heir(exact_rounds(), fleet.knowledge());
  std::optional<SeparatorPrior> old;
  std::map<KeyframeId, KeyframePose> poses;
  for (int r = 0; r < 3; ++r) {
    for (const Fact& fact : fleet.round()) {
      first.add(fact);
      heir.add(fact);
    }
    first.end_round(fleet.now(), executor);
    if (r != 0) continue;
    old = first.separator();
    poses = first.last().keyframes;
  }
  SeparatorPrior broken = *old;
  broken.H(0, 0) = -broken.H(0, 0);
  EXPECT_FALSE(heir.take_over(broken, poses)) << "information below none";
  broken = *old;
  broken.nodes[0].node = 4711;
  EXPECT_FALSE(heir.take_over(broken, poses)) << "of a node that nobody has";
  EXPECT_FALSE(heir.take_over(*old, {})) << "where the keyframes are nobody said";
  ASSERT_TRUE(heir.take_over(*old, poses));
  const FleetEstimate& late = heir.estimate(executor);
  EXPECT_EQ(heir.work().whole, 0U);
  for (const auto& [id, pose] : first.last().keyframes) {
    if (pose.t <= first.separator()->until - Duration::from_s(8.0)) continue;
    const SE3& other = late.keyframes.at(id).T_map_body;
    EXPECT_LT(geometry::boxminus(other, pose.T_map_body).norm(), 2e-3);
  }
}

struct Room {
  double slip_m = 0.4;  ///< of v2's odometry
  ReopenBy reopen = ReopenBy::kMisfit;
  int rounds_before = 0;  ///< in which both are at standstill
  int kept = 100;
  int near_rounds = 3;
  double wrong_chi2 = 40.0;
};

FleetSettings settings_of(const Room& room) {
  FleetSettings settings;
  settings.solve = SolveWhat::kRounds;
  settings.separator.reopen = room.reopen;
  settings.separator.kept = room.kept;
  settings.joint.steps = StepWeight::kIsotropic;
  settings.separator.near_rounds = room.near_rounds;
  settings.joint.isotropic_m = 0.2;
  settings.joint.graph.veto_exact_to = room.wrong_chi2;
  settings.init.commit.information_min = 0.05;
  return settings;
}

/// v1 maps a room in one round; v2 drives through it in the next. @param solved with a last
/// estimate
RoundCentre through_a_room(const Room& room, bool solved = true) {
  FleetKnowledge known;
  GivenStart start;
  start.vehicle = VehicleId{1};
  start.T_relative_vehicle.p = {0.0, 1.5, 0.0};
  start.sigma_m = 0.05;
  start.sigma_rad = 0.01;
  known.starts.push_back(start);
  RoundCentre centre(settings_of(room), known);
  Rng rng(3, "room");
  const places::test::World world = places::test::room();
  SerialExecutor executor;
  std::vector<std::uint32_t> facts(2, 0), nodes(2, 0);
  double t_s = 0.0;
  const auto drive = [&](std::uint16_t v, double x_m, double error_m, bool sees) {
    t_s += 0.5;
    SE3 T_world_body;
    T_world_body.p = {1.5 + x_m, 3.5 + 1.5 * v, 0.0};
    Increment step;
    step.node = nodes[v];
    step.keyframe = nodes[v];
    step.begins = nodes[v] == 0;
    step.levelled = true;
    step.T_odom_body.p.x() = x_m + error_m;
    step.covariance = geometry::Mat6::Identity() * 9e-4;  // it slips, and the map moves with it
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    centre.add({{VehicleId{v}, 0, facts[v]++}, Time::from_s(t_s), step});
    if (sees) {
      const places::test::Scan scan = places::test::look(world, T_world_body, rng);
      KeyframePoints points;
      points.keyframe = nodes[v];
      points.T_body_lidar.p.z() = 0.6;
      points.points = PackedPoints(PointArrays{scan.x_m, scan.y_m, scan.z_m, {}});
      centre.add({{VehicleId{v}, 0, facts[v]++}, Time::from_s(t_s), points});
    }
    ++nodes[v];
  };
  drive(1, 0.0, 0.0, false);
  for (int r = 0; r < room.rounds_before; ++r) {
    for (int k = 0; k < 3; ++k) {
      drive(0, 0.0, 0.0, false);
      drive(1, 0.0, 0.0, false);
    }
    centre.end_round(Time::from_s(t_s), executor);
  }
  for (int k = 0; k <= 16; ++k) drive(0, 0.5 * k, 0.0, true);
  drive(1, 0.0, 0.0, false);
  centre.end_round(Time::from_s(t_s), executor);
  for (int k = 1; k <= 16; ++k) drive(1, 0.5 * k, k > 4 ? room.slip_m : 0.0, k > 4);
  drive(0, 8.0, 0.0, false);
  if (solved) centre.estimate(executor);
  return centre;
}

TEST(RoundCentre, an_inconsistent_loop_to_an_earlier_round_triggers_a_full_solution) {
  const RoundCentre centre = through_a_room({});
  EXPECT_EQ(centre.work().whole, 2U);
  const auto& keyframes = centre.last().keyframes;
  const Vec3 step =
      keyframes.at({VehicleId{1}, 17}).T_map_body.p - keyframes.at({VehicleId{0}, 16}).T_map_body.p;
  EXPECT_NEAR(step.x(), 0.0, 0.1) << "0.4 m without the loop";
  EXPECT_TRUE(std::any_of(centre.last().loops.begin(), centre.last().loops.end(),
                          [](const LoopVerdict& loop) { return loop.accepted; }));
}

TEST(RoundCentre, a_loop_into_the_last_round_reopens_only_that_round) {
  const RoundCentre back = through_a_room({.rounds_before = 3});
  EXPECT_EQ(back.work().whole, 1U) << "the first estimate";
  EXPECT_EQ(back.work().reopened, 1U);
  const RoundCentre all = through_a_room({.rounds_before = 3, .kept = 0});
  EXPECT_EQ(all.work().whole, 2U);
  EXPECT_LT(back.work().nodes, all.work().nodes);
  ASSERT_EQ(back.last().keyframes.size(), all.last().keyframes.size());
  for (const auto& [id, pose] : all.last().keyframes) {
    const KeyframePose& other = back.last().keyframes.at(id);
    const double moved = geometry::boxminus(other.T_map_body, pose.T_map_body).norm();
    if (id.seq < 8) {  // before the separator: as its round left it
      EXPECT_LT(moved, 3.0 * std::sqrt(other.covariance(3, 3))) << id.seq;
      continue;
    }
    EXPECT_LT(moved, 2e-3) << id.seq;
    EXPECT_LT((other.covariance - pose.covariance).norm(), 0.05 * pose.covariance.norm() + 1e-9);
  }
  EXPECT_EQ(back.last().loops.size(), all.last().loops.size());
  EXPECT_EQ(back.separator()->until, all.separator()->until);
}

// The same loop, where less than the uncertainty of both poses counts as certainly wrong.
TEST(RoundCentre, a_loop_that_would_be_rejected_reopens_no_round) {
  EXPECT_EQ(through_a_room({.rounds_before = 3}).work().reopened, 1U);
  const RoundCentre strict = through_a_room({.rounds_before = 3, .wrong_chi2 = 1e-3});
  EXPECT_EQ(strict.work().reopened, 0U);
  EXPECT_EQ(strict.work().whole, 1U);
}

TEST(RoundCentre, a_consistent_loop_reopens_only_recent_rounds) {
  EXPECT_EQ(through_a_room({.slip_m = 0.0, .rounds_before = 3}).work().reopened, 1U);
  EXPECT_EQ(through_a_room({.slip_m = 0.0, .rounds_before = 3, .near_rounds = 0}).work().reopened,
            0U);
}

TEST(RoundCentre, a_consistent_loop_triggers_a_full_solution_only_in_paper_mode) {
  EXPECT_EQ(through_a_room({0.0, ReopenBy::kMisfit}).work().whole, 1U);
  EXPECT_EQ(through_a_room({0.0, ReopenBy::kAny}).work().whole, 2U);
}

/// Raises a flag before a block: work is cancelled in the middle of it.
class RaisingExecutor final : public Executor {
 public:
  RaisingExecutor(std::atomic<bool>& flag, int at) : flag_(flag), at_(at) {}

  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    for (std::size_t begin = 0, index = 0; begin < n; begin += block, ++index) {
      if (at_-- == 0) flag_ = true;
      f(index, begin, std::min(n, begin + block));
    }
  }

 private:
  std::atomic<bool>& flag_;
  int at_;
};

void expect_same(const FleetEstimate& a, const FleetEstimate& b, int at) {
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size()) << at;
  for (const auto& [id, pose] : a.keyframes) {
    const SE3& other = b.keyframes.at(id).T_map_body;
    EXPECT_EQ(geometry::boxminus(other, pose.T_map_body).norm(), 0.0) << at << ' ' << id.seq;
  }
  EXPECT_EQ(a.loops.size(), b.loops.size()) << at;
}

TEST(RoundCentre, cancelling_a_solution_at_any_point_leaves_the_state_unchanged) {
  for (const int kept : {100, 0}) {
    const RoundCentre begin = through_a_room({.rounds_before = 3, .kept = kept}, false);
    SerialExecutor executor;
    RoundCentre straight = begin;
    straight.estimate(executor);
    int given_up = 0;
    for (int at = 0;; ++at) {
      RoundCentre centre = begin;
      std::atomic<bool> flag = false;
      RaisingExecutor raising(flag, at);
      centre.estimate(raising, StopFlag(flag));
      if (!flag) break;
      ++given_up;
      expect_same(centre.last(), begin.last(), at);
      centre.estimate(executor);
      expect_same(centre.last(), straight.last(), at);
      ASSERT_EQ(centre.separator()->until, straight.separator()->until);
    }
    EXPECT_GE(given_up, 5);
  }
}

}  // namespace
}  // namespace rali::fleet
