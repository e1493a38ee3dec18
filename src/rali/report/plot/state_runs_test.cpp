#include "rali/report/plot/state_runs.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rali::report {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(StateRuns, begin_and_end_where_the_state_changes) {
  // Columns of 1: state 0 on 0..3, state 2 on 3..5, state 1 from 5.
  const auto runs =
      state_runs({{0, 0}, {1, 0}, {2, 0}, {3, 2}, {4, 2}, {5, 1}, {6, 1}}, 10.0, 2.0, 10);
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[0].state, 0U);
  EXPECT_EQ(runs[0].end, 3.0);
  EXPECT_EQ(runs[1].begin, 3.0);
  EXPECT_EQ(runs[1].end, 5.0);
  EXPECT_EQ(runs[1].state, 2U);
  EXPECT_EQ(runs[2].end, 7.0);
}

TEST(StateRuns, hide_no_single_bad_sweep_among_a_million_good_ones) {
  std::vector<StateSample> samples;
  for (int i = 0; i < 1'000'000; ++i) samples.push_back({0.1 * i, i == 543'210 ? 3U : 0U});
  const auto runs = state_runs(samples, 100'000.0, 1.0, 600);
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[1].state, 3U);
  EXPECT_LE(runs[1].begin, 54'321.0);
  EXPECT_GE(runs[1].end, 54'321.0);
}

TEST(StateRuns, leave_gaps_empty_and_take_no_value_that_is_none) {
  const auto runs =
      state_runs({{0, 1}, {1, 1}, {7, 1}, {8, 1}, {kNaN, 3}, {-5, 3}, {1e300, 3}}, 10.0, 2.0, 10);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].end, 2.0);
  EXPECT_EQ(runs[1].begin, 7.0);
  EXPECT_EQ(runs[1].state, 1U);
  EXPECT_TRUE(state_runs({{0, 1}}, kNaN, 1.0, 10).empty());
  EXPECT_TRUE(state_runs({{0, 1}}, 0.0, 1.0, 10).empty());
  EXPECT_TRUE(state_runs({}, 5.0, 1.0, 10).empty());
}

}  // namespace
}  // namespace rali::report
