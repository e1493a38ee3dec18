#include "rali/degeneracy/roc.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace rali::degeneracy {
namespace {

TEST(Roc, of_five_scans_matches_hand_computed_values) {
  // Degenerate 1, 3; observable 2, 4, 5. Right pairs: (1,2) (1,4) (1,5) (3,4) (3,5); one is wrong.
  const std::vector<Judged> scans{
      {5.0, false}, {1.0, true}, {3.0, true}, {2.0, false}, {4.0, false}};
  const Roc roc = roc_of(scans);
  EXPECT_EQ(roc.degenerate, 2);
  EXPECT_EQ(roc.seen, 3);
  EXPECT_NEAR(roc.auc, 5.0 / 6.0, 1e-12);
  EXPECT_NEAR(roc.hit_at_5, 0.5,
              1e-12);  // to detect the second one, a third of the observable are false alarms
  EXPECT_NEAR(roc.best_score, 4.0, 1e-12);
  const Rates at = rates_at(scans, roc.best_score);
  EXPECT_NEAR(at.hit, 1.0, 1e-12);
  EXPECT_NEAR(at.false_alarm, 1.0 / 3.0, 1e-12);
}

TEST(Roc, equal_scores_count_half_and_are_not_split) {
  const std::vector<Judged> scans{{0.0, true}, {0.0, true}, {0.0, false}, {7.0, false}};
  const Roc roc = roc_of(scans);
  EXPECT_NEAR(roc.auc, (2.0 + 0.5 * 2.0) / 4.0, 1e-12);
  EXPECT_EQ(roc.hit_at_5, 0.0);
}

TEST(Roc, has_auc_0_for_an_inverted_detector_and_half_for_chance) {
  const std::vector<Judged> inverted{{9.0, true}, {8.0, true}, {1.0, false}, {2.0, false}};
  EXPECT_EQ(roc_of(inverted).auc, 0.0);
  const std::vector<Judged> coin{{1.0, true}, {1.0, false}};
  EXPECT_EQ(roc_of(coin).auc, 0.5);
}

TEST(Roc, ranks_infinite_scores_above_all_finite_ones) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Judged> scans{{inf, false}, {1.0, true}, {inf, false}};
  EXPECT_EQ(roc_of(scans).auc, 1.0);
  EXPECT_EQ(roc_of(scans).hit_at_5, 1.0);
}

TEST(Roc, has_auc_zero_with_one_class_or_no_scans) {
  EXPECT_EQ(roc_of({}).auc, 0.0);
  const std::vector<Judged> scans{{1.0, true}};
  EXPECT_EQ(roc_of(scans).auc, 0.0);
  EXPECT_EQ(rates_at(scans, 2.0).hit, 1.0);
  EXPECT_EQ(rates_at(scans, 2.0).false_alarm, 0.0);
  EXPECT_EQ(rates_at({}, 2.0).false_alarm, 0.0);
}

}  // namespace
}  // namespace rali::degeneracy
