#include "rali/ranging/arrival_clock.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

constexpr double kSkew = 30e-6;
constexpr double kBoot = 1234.0;  ///< device time at host time 0

Time host(double t_s) { return Time::from_s(1.7e5 + t_s); }

Duration device(double t_s) { return Duration::from_s(kBoot + t_s * (1.0 + kSkew)); }

/// Delays with mean 10 ms, of which 2 % have 100 ms more.
double delay_s(Rng& rng) {
  const double jitter = -0.010 * std::log(1.0 - rng.uniform());
  return jitter + (rng.uniform() < 0.02 ? 0.1 : 0.0);
}

/// A clock that received 20 messages a second.
ArrivalClock received(double duration_s, std::uint64_t seed) {
  ArrivalClock clock{ArrivalClockSettings{}};
  Rng rng(seed, "arrival");
  for (int i = 0; i <= std::lround(duration_s * 20.0); ++i) {
    const double t = 0.05 * i;
    (void)clock.add(device(t), host(t + delay_s(rng)));
  }
  return clock;
}

double error_ms(const ArrivalClock& clock, double t_s) {
  return 1e3 * std::abs(seconds_between(host(t_s), *clock.host_time(device(t_s))));
}

// The simulation of algorithms 4.6: 0.10 +- 0.07 ms, of which three sds are 0.31 ms.
TEST(ArrivalClock, after_10_s_has_a_mean_error_below_0_15_ms) {
  double mean_ms = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double e = error_ms(received(10.0, seed), 5.0);
    EXPECT_LT(e, 0.35) << seed;
    mean_ms += e / 20.0;
  }
  EXPECT_LT(mean_ms, 0.15);
}

TEST(ArrivalClock, after_60_s_has_an_error_below_0_2_ms) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const ArrivalClock clock = received(60.0, seed);
    EXPECT_LT(error_ms(clock, 30.0), 0.1) << seed;
    EXPECT_LT(error_ms(clock, 60.0), 0.2) << seed;
  }
}

TEST(ArrivalClock, follows_a_drift_change_by_forgetting_arrivals_before_its_window) {
  // A clock whose drift changes sign: only the last minute is a line.
  ArrivalClock clock{ArrivalClockSettings{}};
  Rng rng(3, "bend");
  const auto bent = [](double t) { return Duration::from_s(t + 50e-6 * std::abs(t - 100.0)); };
  for (int i = 0; i <= 4000; ++i) {
    const double t = 0.05 * i;
    (void)clock.add(bent(t), host(t + delay_s(rng)));
  }
  // Along the old line the error would be 100 s x 100 ppm = 10 ms.
  EXPECT_LT(std::abs(seconds_between(host(200.0), *clock.host_time(bent(200.0)))), 0.5e-3);
  EXPECT_EQ(clock.restarts(), 0);
}

TEST(ArrivalClock, without_delays_is_exact_from_the_first_message) {
  ArrivalClock clock{ArrivalClockSettings{}};
  for (int i = 0; i < 100; ++i) {
    const double t = 0.05 * i;
    EXPECT_LT(std::abs(seconds_between(host(t), clock.add(device(t), host(t)))), 2e-6) << i;
  }
}

TEST(ArrivalClock, no_stamp_is_later_than_its_arrival) {
  ArrivalClock clock{ArrivalClockSettings{}};
  Rng rng(9, "causal");
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.05 * i;
    const Time arrival = host(t + delay_s(rng));
    EXPECT_LE(clock.add(device(t), arrival).ns, arrival.ns + 10);
  }
}

TEST(ArrivalClock, limits_the_estimated_drift_to_100_ppm) {
  ArrivalClock clock{ArrivalClockSettings{}};
  for (int i = 0; i <= 200; ++i) {
    const double t = 0.05 * i;
    (void)clock.add(Duration::from_s(t), host(t * 1.01));
  }
  // 10 s ahead it goes on with 100 ppm from the line below all points, which starts at 0.
  const double ahead_s = seconds_between(host(20.0), *clock.host_time(Duration::from_s(20.0)));
  EXPECT_NEAR(ahead_s, 20.0 * 100e-6, 1e-6);
}

TEST(ArrivalClock, restarts_when_the_device_restarts) {
  ArrivalClock clock = received(10.0, 1);
  const Time after = clock.add(Duration::from_s(0.5), host(12.0));  // it was switched off and on
  EXPECT_EQ(clock.restarts(), 1);
  EXPECT_EQ(after, host(12.0));
}

TEST(ArrivalClock, restarts_when_the_device_clock_jumps_forward_by_1_2_s) {
  ArrivalClock clock = received(10.0, 1);
  (void)clock.add(device(10.05) + Duration::from_s(1.2), host(10.05));
  EXPECT_EQ(clock.restarts(), 1);
  ArrivalClock steady = received(10.0, 1);
  (void)steady.add(device(10.05) + Duration::from_s(0.8), host(10.05));
  EXPECT_EQ(steady.restarts(), 0);
}

TEST(ArrivalClock, does_not_restart_after_a_pause_of_both_clocks) {
  ArrivalClock clock = received(10.0, 1);
  const Time after = clock.add(device(310.0), host(310.012));
  EXPECT_EQ(clock.restarts(), 0);
  EXPECT_LE(after, host(310.012));
}

TEST(ArrivalClock, restarts_after_ten_late_messages_in_a_row) {
  ArrivalClock clock = received(20.0, 1);
  for (int i = 1; i < 10; ++i) {
    const double t = 20.0 + 0.05 * i;
    const Time stamp = clock.add(device(t), host(t + 3.0));
    EXPECT_LT(std::abs(seconds_between(host(t), stamp)), 1e-3) << i;
  }
  EXPECT_EQ(clock.restarts(), 0);
  (void)clock.add(device(20.5), host(23.5));
  EXPECT_EQ(clock.restarts(), 1);
}

TEST(ArrivalClock, one_stamp_repeated_keeps_its_earliest_arrival) {
  ArrivalClock clock{ArrivalClockSettings{}};
  (void)clock.add(device(0.0), host(0.050));
  (void)clock.add(device(0.0), host(0.010));
  EXPECT_EQ(clock.add(device(0.0), host(0.090)), host(0.010));
}

TEST(ArrivalClock, has_no_estimate_before_the_first_message) {
  const ArrivalClock clock{ArrivalClockSettings{}};
  EXPECT_FALSE(clock.host_time(Duration::from_s(1.0)));
}

TEST(MillisecondCount, continues_across_the_32_bit_wrap) {
  MillisecondCount count;
  const std::uint32_t maximum = std::numeric_limits<std::uint32_t>::max();
  const Duration before = count.unwrap(maximum - 9);
  EXPECT_EQ(before.ns, 4294967286000000);
  EXPECT_EQ(count.unwrap(maximum) - before, Duration::from_s(0.009));
  EXPECT_EQ(count.unwrap(0) - before, Duration::from_s(0.010));
  EXPECT_EQ(count.unwrap(40) - before, Duration::from_s(0.050));
}

TEST(MillisecondCount, goes_back_when_the_device_restarts) {
  MillisecondCount count;
  (void)count.unwrap(60000);
  EXPECT_EQ(count.unwrap(500), Duration::from_s(0.5));
}

TEST(MillisecondCount, keeps_the_clock_running_across_the_wrap) {
  MillisecondCount count;
  ArrivalClock clock{ArrivalClockSettings{}};
  for (std::uint32_t i = 0; i < 400; ++i) {
    const std::uint32_t ms = std::numeric_limits<std::uint32_t>::max() - 9999 + 50 * i;
    const Time stamp = clock.add(count.unwrap(ms), host(0.05 * i));
    EXPECT_LT(std::abs(seconds_between(host(0.05 * i), stamp)), 1e-6) << i;
  }
  EXPECT_EQ(clock.restarts(), 0);
}

}  // namespace
}  // namespace rali::ranging
