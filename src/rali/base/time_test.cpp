#include "rali/base/time.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace rali {
namespace {

constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();

TEST(Duration, seconds_are_rounded_to_the_nearest_nanosecond) {
  EXPECT_EQ(Duration::from_s(1.0).ns, 1'000'000'000);
  EXPECT_EQ(Duration::from_s(0.1).ns, 100'000'000);  // 0.1 is not a double: truncation would lose 1
  EXPECT_EQ(Duration::from_s(1.4e-9).ns, 1);
  EXPECT_EQ(Duration::from_s(1.6e-9).ns, 2);
  EXPECT_EQ(Duration::from_s(-1.6e-9).ns, -2);
  EXPECT_EQ(Duration::from_s(-0.0).ns, 0);
}

TEST(Duration, out_of_range_seconds_are_clamped) {
  EXPECT_EQ(Duration::from_s(1e300).ns, kMax);
  EXPECT_EQ(Duration::from_s(-1e300).ns, kMin);
  EXPECT_EQ(Duration::from_s(std::numeric_limits<double>::infinity()).ns, kMax);
  EXPECT_EQ(Duration::from_s(-std::numeric_limits<double>::infinity()).ns, kMin);
  EXPECT_EQ(Duration::from_s(9.2e9).ns, kMax);
  EXPECT_LT(Duration::from_s(9.1e9).ns, kMax);
}

TEST(Duration, from_nan_is_zero) {
  EXPECT_EQ(Duration::from_s(std::numeric_limits<double>::quiet_NaN()).ns, 0);
  EXPECT_EQ(Time::from_s(std::nan("")).ns, 0);
}

TEST(Time, keeps_nanoseconds_of_stamps_since_1970) {
  const Time t = Time::from_ns(1'700'000'000'123'456'789);
  const Time later = t + Duration::from_ns(1);
  EXPECT_EQ((later - t).ns, 1);
  EXPECT_GT(later, t);
  EXPECT_DOUBLE_EQ(seconds_between(t, t + Duration::from_s(0.25)), 0.25);
  EXPECT_EQ((t - Duration::from_s(2.0) - t).ns, -2'000'000'000);
  EXPECT_EQ((-Duration::from_s(2.0)).ns, -2'000'000'000);
}

TEST(Time, compares_by_nanoseconds) {
  EXPECT_LT(Time::from_ns(-1), Time::from_ns(0));
  EXPECT_EQ(Time::from_s(3.0), Time::from_ns(3'000'000'000));
  EXPECT_LT(Duration::from_ns(4), Duration::from_ns(5));
}

}  // namespace
}  // namespace rali
