#include "rali/ranging/signal_quality.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

SignalQuality with_powers(double rssi_dbm, double first_path_dbm, const SignalSettings& s = {}) {
  sensor::RangeSample sample;
  sample.rssi_dbm = rssi_dbm;
  sample.first_path_dbm = first_path_dbm;
  return signal_quality(sample, s);
}

SignalQuality with_gap(double gap_db) { return with_powers(-80.0, -80.0 - gap_db); }

TEST(SignalQuality, sigma_factor_rises_from_6_to_10_db_power_difference) {
  EXPECT_EQ(with_gap(0.8).sigma_factor, 1.0);
  EXPECT_EQ(with_gap(6.0).sigma_factor, 1.0);
  EXPECT_NEAR(with_gap(7.0).sigma_factor, 2.0, 1e-12);
  EXPECT_NEAR(with_gap(8.0).sigma_factor, 3.0, 1e-12);
  EXPECT_NEAR(with_gap(10.0).sigma_factor, 5.0, 1e-12);
  EXPECT_EQ(with_gap(10.1).sigma_factor, 10.0);
  EXPECT_EQ(with_gap(60.0).sigma_factor, 10.0);
}

TEST(SignalQuality, line_of_sight_probability_stays_between_0_1_and_0_8) {
  EXPECT_NEAR(with_gap(0.0).p_los, 0.8, 1e-12);
  EXPECT_NEAR(with_gap(8.0).p_los, 0.45, 1e-12);
  EXPECT_NEAR(with_gap(10.0).p_los, 0.1, 1e-12);
  EXPECT_NEAR(with_gap(100.0).p_los, 0.1, 1e-12);
}

TEST(SignalQuality, a_first_path_stronger_than_the_total_is_a_clear_signal) {
  EXPECT_EQ(with_gap(-0.5).sigma_factor, 1.0);
  EXPECT_TRUE(with_gap(-0.5).clear());
}

TEST(SignalQuality, without_both_powers_nothing_is_reported) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const SignalQuality& q :
       {with_powers(0.0, 0.0), with_powers(-80.0, 0.0), with_powers(0.0, -95.0),
        with_powers(std::nan(""), -95.0), with_powers(-inf, -95.0), with_powers(-80.0, -inf)}) {
    EXPECT_TRUE(q.clear());
    EXPECT_TRUE(std::isnan(q.gap_db));
    EXPECT_TRUE(std::isnan(q.p_los));
  }
}

TEST(SignalQuality, equal_or_reversed_limits_give_a_step_without_division_by_zero) {
  SignalSettings s;
  s.clear_db = s.blocked_db = 8.0;
  EXPECT_EQ(with_powers(-80.0, -87.9, s).sigma_factor, 1.0);
  EXPECT_EQ(with_powers(-80.0, -88.1, s).sigma_factor, 10.0);
  s.blocked_db = 4.0;
  EXPECT_EQ(with_powers(-80.0, -85.0, s).sigma_factor, 1.0);
  EXPECT_EQ(with_powers(-80.0, -90.0, s).sigma_factor, 10.0);
}

}  // namespace
}  // namespace rali::ranging
