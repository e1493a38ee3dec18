#include "rali/ranging/exchange_pairer.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

using sensor::RangeSample;

RangeSample range(double t_s, std::uint16_t from, std::uint16_t to, double range_m) {
  RangeSample s;
  s.t = Time::from_s(100.0 + t_s);
  s.from.value = from;
  s.to.value = to;
  s.range_m = range_m;
  return s;
}

/// A pairer and all its output.
struct Fed {
  ExchangePairer pairer{ExchangeSettings{}};
  std::vector<PairedRange> out;

  void add(const RangeSample& s) { pairer.add(s, out); }

  /// What came out since the last call: ranges passed on (positive), duplicates (negative).
  std::vector<double> reported() {
    std::vector<double> ranges;
    for (const PairedRange& p : out) {
      ranges.push_back(p.duplicate ? -p.sample.range_m : p.sample.range_m);
    }
    out.clear();
    return ranges;
  }

  /// Makes both directions of the pair 1-2 known, long before.
  void receive_both() {
    add(range(-10.0, 1, 2, 5.0));
    add(range(-9.0, 2, 1, 5.0));
    pairer.flush(out);
    out.clear();
  }
};

using Reported = std::vector<double>;

TEST(ExchangePairer, both_directions_of_one_exchange_are_one_range) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  EXPECT_EQ(fed.reported(), Reported{});  // waits
  fed.add(range(0.004, 2, 1, 10.2));
  ASSERT_EQ(fed.out.size(), 2u);
  EXPECT_EQ(fed.out[0].sample.t, Time::from_s(100.002));
  EXPECT_EQ(fed.out[0].sample.from.value, 1);
  EXPECT_EQ(fed.reported(), (Reported{10.1, -10.2}));
}

TEST(ExchangePairer, directions_half_a_slot_apart_are_two_ranges) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  fed.add(range(0.011, 2, 1, 10.2));
  EXPECT_EQ(fed.reported(), (Reported{10.0}));
  fed.pairer.flush(fed.out);
  EXPECT_EQ(fed.reported(), (Reported{10.2}));
}

TEST(ExchangePairer, never_delays_a_link_reported_by_one_end_only) {
  Fed fed;
  for (int i = 0; i < 5; ++i) {
    fed.add(range(0.05 * i, 1, 2, 10.0 + i));
    EXPECT_EQ(fed.reported(), (Reported{10.0 + i}));
  }
}

TEST(ExchangePairer, marks_the_first_reverse_measurement_of_a_link_as_duplicate) {
  Fed fed;
  fed.add(range(0.000, 1, 2, 10.0));
  fed.add(range(0.001, 2, 1, 10.2));
  EXPECT_EQ(fed.reported(), (Reported{10.0, -10.2}));
}

TEST(ExchangePairer, marks_a_repeated_message_as_duplicate) {
  Fed fed;
  fed.add(range(0.0, 1, 2, 10.0));
  fed.add(range(0.0, 1, 2, 10.0));
  fed.add(range(0.5, 1, 2, 11.0));
  fed.add(range(0.0, 1, 2, 10.0));  // again, by another route and later
  EXPECT_EQ(fed.reported(), (Reported{10.0, -10.0, 11.0, -10.0}));
}

TEST(ExchangePairer, assigns_late_messages_to_their_exchange) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.00, 1, 2, 10.0));
  fed.add(range(0.05, 1, 2, 10.1));
  fed.add(range(0.10, 1, 2, 10.2));
  EXPECT_EQ(fed.reported(), (Reported{10.0, 10.1}));
  fed.add(range(0.002, 2, 1, 10.01));
  EXPECT_EQ(fed.reported(), (Reported{-10.01}));
  fed.add(range(0.025, 2, 1, 10.05));  // an exchange of its own, late
  EXPECT_EQ(fed.reported(), (Reported{10.05}));
}

TEST(ExchangePairer, merges_at_most_two_directions_per_exchange) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  fed.add(range(0.002, 2, 1, 10.0));
  fed.add(range(0.004, 2, 1, 10.3));
  fed.pairer.flush(fed.out);
  EXPECT_EQ(fed.reported(), (Reported{10.0, -10.0, 10.3}));
}

TEST(ExchangePairer, antennas_of_one_vehicle_are_not_mixed_up) {
  Fed fed;
  RangeSample a = range(0.000, 1, 2, 10.0);
  RangeSample b = range(0.001, 2, 1, 10.2);
  a.from_antenna = 1;  // 1.1 to 2.0, and 2.0 to 1.0
  fed.add(a);
  fed.add(b);
  EXPECT_EQ(fed.reported(), (Reported{10.0, 10.2}));
  b.to_antenna = 1;
  fed.add(b);
  EXPECT_EQ(fed.reported(), (Reported{-10.2}));
}

TEST(ExchangePairer, directions_that_contradict_each_other_are_both_passed_on) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  fed.add(range(0.004, 2, 1, 14.0));
  EXPECT_EQ(fed.reported(), (Reported{10.0, 14.0}));
}

TEST(ExchangePairer, ranges_of_one_pair_leave_in_order_of_time) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  fed.add(range(0.003, 1, 2, 10.1));  // a second exchange within half a slot
  fed.add(range(0.006, 1, 2, 10.2));
  fed.pairer.flush(fed.out);
  EXPECT_EQ(fed.reported(), (Reported{10.0, 10.1, 10.2}));
}

TEST(ExchangePairer, nothing_waits_longer_than_half_a_slot) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, 10.0));
  fed.pairer.release(Time::from_s(100.009), fed.out);
  EXPECT_EQ(fed.reported(), Reported{});
  fed.pairer.release(Time::from_s(100.011), fed.out);
  EXPECT_EQ(fed.reported(), (Reported{10.0}));
  fed.pairer.flush(fed.out);
  EXPECT_EQ(fed.reported(), Reported{});

  fed.add(range(0.100, 1, 2, 10.0));
  fed.add(range(0.120, 3, 4, 20.0));  // a range of another pair releases it as well
  EXPECT_EQ(fed.reported(), (Reported{10.0, 20.0}));
}

TEST(ExchangePairer, a_merged_range_combines_sigma_and_signal_strength_of_both) {
  Fed fed;
  fed.receive_both();
  RangeSample a = range(0.000, 1, 2, 10.0);
  RangeSample b = range(0.004, 2, 1, 10.2);
  a.sigma_m = 0.1;
  b.sigma_m = 0.3;
  a.rssi_dbm = -80.0;
  b.rssi_dbm = -82.0;
  b.first_path_dbm = -83.0;
  fed.add(a);
  fed.add(b);
  const RangeSample& m = fed.out.front().sample;
  EXPECT_EQ(m.sigma_m, 0.3);
  EXPECT_EQ(m.rssi_dbm, -81.0);
  EXPECT_EQ(m.first_path_dbm, -83.0);
}

TEST(ExchangePairer, passes_on_a_nan_range_without_merging_it) {
  Fed fed;
  fed.receive_both();
  fed.add(range(0.000, 1, 2, std::nan("")));
  fed.add(range(0.001, 2, 1, 10.0));
  fed.pairer.flush(fed.out);
  ASSERT_EQ(fed.out.size(), 2u);
  EXPECT_FALSE(fed.out[0].duplicate);
  EXPECT_EQ(fed.out[1].sample.range_m, 10.0);
}

TEST(ExchangePairer, bounds_its_history_even_if_a_clock_goes_back) {
  ExchangeSettings s;
  s.history = 3;
  ExchangePairer pairer(s);
  std::vector<PairedRange> out;
  for (int i = 0; i < 5; ++i) pairer.add(range(1000.0 + i, 1, 2, 10.0), out);
  for (int i = 0; i < 5; ++i) pairer.add(range(i, 1, 2, 10.0), out);
  out.clear();
  pairer.add(range(4.0, 1, 2, 10.0), out);  // still known
  EXPECT_TRUE(out.front().duplicate);
  out.clear();
  pairer.add(range(1000.0, 1, 2, 10.0), out);  // forgotten
  EXPECT_FALSE(out.front().duplicate);
}

}  // namespace
}  // namespace rali::ranging
