#include "rali/drive/ranges/range_latency.hpp"

#include <array>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

constexpr double kPrior_s = 0.02;

/// Posterior of a filter with that prior for a motion estimate of `latency_s` with `sigma_s`.
vehicle::RangeStampOffset filtered(double latency_s, double sigma_s) {
  const double prior = 1.0 / (kPrior_s * kPrior_s), motion = 1.0 / (sigma_s * sigma_s);
  return {-latency_s * motion / (prior + motion), 1.0 / std::sqrt(prior + motion)};
}

TEST(RangeLatency, is_estimated_from_motion_without_the_prior_of_the_filter) {
  const auto latency = latency_by_motion(filtered(0.046, 0.005), kPrior_s);
  ASSERT_TRUE(latency);
  EXPECT_NEAR(latency->value_s, 0.046, 1e-12) << "the filter alone has 43 ms";
  EXPECT_NEAR(*latency->sigma_s, 0.005, 1e-12);
  EXPECT_EQ(latency_words(*latency), "46 ms, sigma 5.0 ms");
}

TEST(RangeLatency, is_unknown_without_sufficient_information) {
  EXPECT_FALSE(latency_by_motion(std::nullopt, kPrior_s)) << "no range was used";
  EXPECT_FALSE(latency_by_motion(vehicle::RangeStampOffset{0.0, kPrior_s}, kPrior_s));
  EXPECT_FALSE(latency_by_motion(filtered(0.5, 0.2), kPrior_s)) << "driving away only";
  EXPECT_FALSE(latency_by_motion(vehicle::RangeStampOffset{NAN, 0.001}, kPrior_s));
}

TEST(RangeLatency, of_several_vehicles_is_weighted_by_their_variances) {
  const std::array<std::optional<RangeLatency>, 3> vehicles = {
      RangeLatency{0.040, 0.003}, std::nullopt, RangeLatency{0.080, 0.030}};
  const auto latency = combined(vehicles);
  ASSERT_TRUE(latency);
  EXPECT_NEAR(latency->value_s, 0.0404, 1e-4);
  EXPECT_LT(*latency->sigma_s, 0.003);
  EXPECT_FALSE(combined({}));
}

}  // namespace
}  // namespace rali::drive
