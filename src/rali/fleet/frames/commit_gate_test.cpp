#include "rali/fleet/frames/commit_gate.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

/// Two hypotheses 2 m apart of 15 ranges; all untested values are valid.
HypothesisSet two(double chi2_best, double chi2_second, int dof = 12) {
  HypothesisSet set;
  set.all.resize(2);
  for (std::size_t k = 0; k < 2; ++k) {
    FrameHypothesis& h = set.all[k];
    h.T_b_a.t_m.x() = 2.0 * static_cast<double>(k);
    h.information = h.drift_information = h.offset_information = Mat4::Identity() * 1e5;
    h.chi2 = h.solution.fit_chi2 = k == 0 ? chi2_best : chi2_second;
    h.solution.dof = dof;
  }
  set.ranges.resize(15);
  for (std::size_t i = 0; i < set.ranges.size(); ++i) {
    const double s = static_cast<double>(i);
    set.ranges[i] = {{s, s * s * 0.1}, {0.3 * s, -s * s * 0.2}, 5.0 + s, 0.07};
  }
  return set;
}

int evaluations_until_commit(const HypothesisSet& set, double spacing_s, int maximum) {
  const InitSettings settings;
  CommitGate gate(settings);
  for (int k = 0; k < maximum; ++k) {
    const Decision d = decide(set, observability(set, settings), 0, settings);
    if (gate.evaluate(Time::from_s(spacing_s * k), d, &set.all.front())) return k + 1;
  }
  return 0;
}

// A single similar place can give a wrong match; a rival that was also recognised once requires one
// more match.
TEST(CommitGate, without_ranges_needs_two_views_and_one_more_per_contradicting_view) {
  const InitSettings settings;
  HypothesisSet set = two(10.0, 60.0);
  set.only_scans = true;
  const auto ready = [&](int views, int against) {
    set.all[0].views = views;
    set.all[1].views = against;
    return decide(set, observability(set, settings), 0, settings).ready;
  };
  EXPECT_FALSE(ready(0, 0));
  EXPECT_FALSE(ready(1, 0));
  EXPECT_TRUE(ready(2, 0));
  EXPECT_FALSE(ready(2, 1));
  EXPECT_TRUE(ready(3, 1));
  set.only_scans = false;
  EXPECT_TRUE(ready(0, 0));
}

// T16
TEST(CommitGate, commits_at_a_chi2_gap_of_14_but_not_of_13) {
  EXPECT_EQ(evaluations_until_commit(two(10.0, 23.0), 2.0, 3), 0);
  EXPECT_EQ(evaluations_until_commit(two(10.0, 24.0), 2.0, 3), 3);
}

TEST(CommitGate, a_poor_fit_reduces_the_chi2_gap_and_a_worse_one_rejects) {
  const InitSettings settings;
  // chi2/dof = 1.5: a gap of 18 counts as 12.
  const HypothesisSet set = two(18.0, 36.0);
  EXPECT_NEAR(decide(set, observability(set, settings), 0, settings).gap_chi2, 12.0, 1e-12);
  EXPECT_EQ(evaluations_until_commit(set, 2.0, 5), 0);
  EXPECT_EQ(evaluations_until_commit(two(23.0, 100.0), 2.0, 3), 3);
  EXPECT_EQ(evaluations_until_commit(two(25.0, 100.0), 2.0, 9), 0);
  const HypothesisSet bad = two(25.0, 100.0);
  EXPECT_EQ(decide(bad, observability(bad, settings), 0, settings).advice, Advice::kMisfit);
}

TEST(CommitGate, accepts_ranges_better_than_their_sigma_unless_fit_min_is_set) {
  // A radio with an error of 5 cm and a configured sigma of 10 cm: chi2/dof about 0.2.
  const HypothesisSet set = two(2.4, 100.0);
  EXPECT_EQ(evaluations_until_commit(set, 2.0, 3), 3);
  InitSettings settings;
  settings.commit.fit_min = 0.5;
  const Decision d = decide(set, observability(set, settings), 0, settings);
  EXPECT_FALSE(d.ready);
  EXPECT_EQ(d.advice, Advice::kTooGood);
}

TEST(CommitGate, requires_evaluations_two_seconds_apart) {
  EXPECT_EQ(evaluations_until_commit(two(10.0, 30.0), 0.5, 8), 0);
  EXPECT_EQ(evaluations_until_commit(two(10.0, 30.0), 0.5, 9), 9);
}

TEST(CommitGate, restarts_its_count_if_the_best_hypothesis_changes_or_is_not_ready) {
  const InitSettings settings;
  const HypothesisSet set = two(10.0, 30.0);
  const Decision ready = decide(set, observability(set, settings), 0, settings);
  ASSERT_TRUE(ready.ready);
  CommitGate gate(settings);
  EXPECT_FALSE(gate.evaluate(Time::from_s(0.0), ready, &set.all[0]));
  EXPECT_FALSE(gate.evaluate(Time::from_s(2.0), ready, &set.all[0]));
  EXPECT_FALSE(gate.evaluate(Time::from_s(4.0), ready, &set.all[1]));
  EXPECT_EQ(gate.agreed(), 1);
  EXPECT_FALSE(gate.evaluate(Time::from_s(6.0), Decision{}, &set.all[1]));
  EXPECT_EQ(gate.agreed(), 0);
  EXPECT_FALSE(gate.evaluate(Time::from_s(8.0), ready, nullptr));
}

TEST(CommitGate, reports_when_the_prior_decided) {
  const InitSettings settings;
  HypothesisSet set = two(10.0, 30.0);
  set.has_prior = true;
  EXPECT_NE(decide(set, observability(set, settings), 0, settings).by, DecidedBy::kPrior);
  set.all[1].prior_chi2 = 10.0;  // without it 10 against 20
  EXPECT_EQ(decide(set, observability(set, settings), 0, settings).by, DecidedBy::kPrior);
  set.all[1].prior_chi2 = 0.0;
  set.all[0].prior_information = set.all[0].information;
  const Decision d = decide(set, observability(set, settings), 0, settings);
  EXPECT_EQ(d.by, DecidedBy::kPrior);
  EXPECT_TRUE(d.ready);
}

TEST(CommitGate, prefers_the_start_pose_if_the_ranges_fit_no_hypothesis) {
  const InitSettings settings;
  HypothesisSet set = two(100.0, 700.0);  // the better one contradicts the start pose
  set.has_prior = true;
  set.all[0].prior_chi2 = settings.prior.wrong_chi2;
  set.all[0].priors_denied = 1;
  set.all[0].solution.dof = 20;
  set.all[0].solution.fit_chi2 = 20.0;
  const Observability seen = observability(set, settings);
  InitSettings wants_more = settings;
  wants_more.commit.min_keyframes = 1;
  EXPECT_FALSE(decide(set, seen, 0, wants_more).ready) << "not certain, but it fits";
  set.all[0].solution.fit_chi2 = 100.0;
  const Decision d = decide(set, seen, 0, wants_more);
  EXPECT_TRUE(d.ready);
  EXPECT_EQ(d.chosen, 1U);
}

// Through the walls of a storey most ranges are a metre too long. Together they fitted another
// place better than the start pose, which was right.
TEST(CommitGate, ranges_too_long_for_the_start_pose_do_not_speak_against_it) {
  const InitSettings settings;
  for (const double obstructed_chi2 : {0.0, 90.0}) {
    HypothesisSet set = two(10.0, 110.0);
    set.has_prior = true;
    set.all[0].priors_denied = 1;
    set.all[1].prior_chi2 = 40.0;  // several start poses, each of which agrees
    set.all[1].solution.obstructed_chi2 = obstructed_chi2;
    const Decision d = decide(set, observability(set, settings), 0, settings);
    EXPECT_EQ(d.chosen, obstructed_chi2 > 0.0 ? 1U : 0U);
    EXPECT_EQ(d.at_once, obstructed_chi2 > 0.0);
  }
}

TEST(CommitGate, by_the_papers_rule_waits_for_ten_keyframes_and_a_prior) {
  InitSettings settings;
  settings.commit.rule = CommitRule::kAtSize;
  settings.commit.min_keyframes = 10;
  HypothesisSet set = two(1e4, 1e4);
  const Observability seen = observability(set, settings);
  EXPECT_EQ(decide(set, seen, 20, settings).advice, Advice::kNoPrior);
  set.has_prior = true;
  EXPECT_EQ(decide(set, seen, 9, settings).advice, Advice::kSmallMap);
  const Decision d = decide(set, seen, 10, settings);
  EXPECT_TRUE(d.ready);
  EXPECT_TRUE(CommitGate(settings).evaluate(Time::from_s(0.0), d, &set.all.front()));
}

}  // namespace
}  // namespace rali::fleet
