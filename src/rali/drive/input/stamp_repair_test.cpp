#include "rali/drive/input/stamp_repair.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

StampPair at(double header_s, double record_s) {
  return {Time::from_s(header_s), Time::from_s(record_s)};
}

std::vector<StampPair> steady(double header_s, double record_s, int n) {
  std::vector<StampPair> pairs;
  for (int i = 0; i < n; ++i) pairs.push_back(at(header_s + 0.1 * i, record_s + 0.1 * i));
  return pairs;
}

StampRepair by_header() { return {StampRule::kHeader, std::make_shared<ClockShifts>()}; }

TEST(DecideStamps, keeps_headers_that_advance_with_record_times) {
  EXPECT_EQ(decide_stamps(steady(1000.0, 5000.0, 20)).rule, StampRule::kHeader);
}

TEST(DecideStamps, takes_record_time_for_zero_and_for_constant_headers) {
  std::vector<StampPair> zero = steady(0.0, 5000.0, 10), constant = zero;
  for (StampPair& p : zero) p.header = Time{};
  for (StampPair& p : constant) p.header = Time::from_s(77.0);
  EXPECT_EQ(decide_stamps(zero).rule, StampRule::kRecord);
  EXPECT_EQ(decide_stamps(zero).reason, "header stamps are zero");
  EXPECT_EQ(decide_stamps(constant).rule, StampRule::kRecord);
}

TEST(DecideStamps, keeps_headers_if_only_the_first_is_zero) {
  std::vector<StampPair> pairs = steady(1000.0, 5000.0, 10);
  pairs[0].header = Time{};
  EXPECT_EQ(decide_stamps(pairs).rule, StampRule::kHeader);
}

TEST(DecideStamps, keeps_headers_if_record_times_are_constant) {
  std::vector<StampPair> pairs = steady(1000.0, 5000.0, 10);
  for (StampPair& p : pairs) p.record = Time::from_s(1.0);
  EXPECT_EQ(decide_stamps(pairs).rule, StampRule::kHeader);
}

TEST(DecideStamps, takes_record_time_for_headers_that_alternate) {
  std::vector<StampPair> pairs = steady(1000.0, 5000.0, 20);
  for (std::size_t i = 0; i < pairs.size(); i += 2) pairs[i].header = Time::from_s(3.0);
  EXPECT_EQ(decide_stamps(pairs).rule, StampRule::kRecord);
}

TEST(StampRepair, passes_a_steady_topic_unchanged) {
  StampRepair repair = by_header();
  for (const StampPair& p : steady(1000.0, 5000.0, 50)) EXPECT_EQ(repair.repair(p), p.header);
  EXPECT_EQ(repair.jumps(), 0U);
}

TEST(StampRepair, removes_forward_and_backward_clock_jumps) {
  StampRepair repair = by_header();
  for (int i = 0; i < 10; ++i) (void)repair.repair(at(100.0 + 0.1 * i, 100.0 + 0.1 * i));
  // Set forward by an hour, then back by two.
  EXPECT_NEAR(repair.repair(at(3701.0, 101.0))->s(), 101.0, 1e-6);
  EXPECT_NEAR(repair.repair(at(3701.1, 101.1))->s(), 101.1, 1e-6);
  EXPECT_NEAR(repair.repair(at(-3498.8, 101.2))->s(), 101.2, 1e-6);
  EXPECT_EQ(repair.jumps(), 2U);
  EXPECT_NEAR(repair.last_jump_s(), -7200.0, 1e-6);
}

TEST(StampRepair, continues_by_one_period_after_both_clocks_are_set_back) {
  StampRepair repair = by_header();
  repair.start_file(true);
  for (int i = 0; i < 20; ++i) (void)repair.repair(at(100.0 + 0.1 * i, 500.0 + 0.1 * i));
  const std::optional<Time> t = repair.repair(at(50.0, 450.0));
  EXPECT_NEAR(t->s(), 102.0, 0.02);
}

TEST(StampRepair, never_shifts_a_message_that_is_only_out_of_order) {
  StampRepair repair = by_header();
  const std::vector<double> seconds = {100.0, 101.0, 250.0, 103.0, 99.0, 104.0, 90.0, 180.0};
  for (const double s : seconds) EXPECT_EQ(repair.repair(at(s, s + 0.02)), Time::from_s(s)) << s;
  // Converted files may have one record time for all.
  StampRepair converted = by_header();
  for (const double s : {100.0, 102.0, 99.5, 103.0, 98.0}) {
    EXPECT_EQ(converted.repair(at(s, 7.0)), Time::from_s(s)) << s;
  }
  EXPECT_EQ(repair.jumps() + converted.jumps(), 0U);
}

TEST(StampRepair, keeps_stamps_after_a_pause_of_120_s) {
  StampRepair repair = by_header();
  (void)repair.repair(at(100.0, 500.0));
  (void)repair.repair(at(100.1, 500.1));
  EXPECT_NEAR(repair.repair(at(220.1, 620.1))->s(), 220.1, 1e-9) << "the recorder was paused";
}

TEST(StampRepair, keeps_stamps_after_a_pause_of_10_s) {
  StampRepair repair = by_header();
  (void)repair.repair(at(100.0, 100.0));
  (void)repair.repair(at(100.1, 100.1));
  EXPECT_NEAR(repair.repair(at(110.1, 110.1))->s(), 110.1, 1e-9);
  EXPECT_EQ(repair.jumps(), 0U);
}

TEST(StampRepair, keeps_headers_if_only_the_recorder_stalls) {
  StampRepair repair = by_header();
  (void)repair.repair(at(100.0, 100.0));
  EXPECT_NEAR(repair.repair(at(100.1, 103.0))->s(), 100.1, 1e-9);
  EXPECT_NEAR(repair.repair(at(100.2, 103.01))->s(), 100.2, 1e-9);
  EXPECT_EQ(repair.jumps(), 0U);
}

TEST(StampRepair, drops_and_counts_repeats) {
  StampRepair repair = by_header();
  (void)repair.repair(at(100.0, 100.0));
  EXPECT_FALSE(repair.repair(at(100.0, 100.01)));
  EXPECT_EQ(repair.repeats(), 1U);
}

TEST(StampRepair, removes_one_jump_by_the_same_amount_in_two_topics) {
  auto shifts = std::make_shared<ClockShifts>();
  StampRepair lidar(StampRule::kHeader, shifts), imu(StampRule::kHeader, shifts);
  (void)lidar.repair(at(100.0, 100.0));
  (void)imu.repair(at(100.0, 100.0));
  const Time a = *imu.repair(at(200.01, 100.012));
  const Time b = *lidar.repair(at(200.10, 100.13));
  EXPECT_NEAR(seconds_between(a, b), 0.09, 1e-9) << "the sensors must not drift apart";
}

TEST(StampRepair, drops_zero_stamps_before_the_first_valid_one) {
  StampRepair repair = by_header();
  EXPECT_FALSE(repair.repair(at(0.0, 5000.0)));
  EXPECT_EQ(repair.repair(at(1000.0, 5000.1)), Time::from_s(1000.0));
}

TEST(StampRepair, handles_extreme_stamp_values) {
  StampRepair repair = by_header();
  constexpr auto kMax = std::numeric_limits<std::int64_t>::max();
  constexpr auto kMin = std::numeric_limits<std::int64_t>::min();
  for (const std::int64_t header : {kMax, kMin, std::int64_t{7}, kMax, kMin + 1}) {
    (void)repair.repair({Time{header}, Time{-header - 1}});
  }
  SUCCEED() << "the sanitizers watch";
}

TEST(StampRepair, accepts_a_later_start_of_a_second_file) {
  StampRepair repair = by_header();
  (void)repair.repair(at(100.0, 100.0));
  repair.start_file();
  EXPECT_EQ(repair.repair(at(4000.0, 4000.0)), Time::from_s(4000.0));
  EXPECT_EQ(repair.jumps(), 0U);
}

}  // namespace
}  // namespace rali::drive
