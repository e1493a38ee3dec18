#include "rali/base/rng.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/internal_error.hpp"

namespace rali {
namespace {

// Golden values from an independent program of the published algorithms.
TEST(Rng, gives_the_published_sequence_for_seed_zero) {
  Rng rng(0);
  const std::array<std::uint64_t, 4> golden{0x53175d61490b23dfULL, 0x61da6f3dc380d507ULL,
                                            0x5c0fdf91ec9a7bfcULL, 0x02eebf8c3bbe5e1aULL};
  for (const std::uint64_t g : golden) EXPECT_EQ(rng.next(), g);
}

TEST(Rng, gives_the_same_sequence_for_a_named_stream_on_every_machine) {
  Rng rng(42, "imu");
  const std::array<std::uint64_t, 3> golden{0x196ac0753d3fc86bULL, 0xeb4184ac03bc0748ULL,
                                            0xaf1899c33371fdd5ULL};
  for (const std::uint64_t g : golden) EXPECT_EQ(rng.next(), g);
}

TEST(Rng, streams_with_different_names_or_seeds_are_uncorrelated) {
  Rng a(7, "gyro");
  Rng b(7, "accel");
  Rng c(8, "gyro");
  double ab = 0.0;
  double ac = 0.0;
  constexpr int kN = 4000;
  for (int k = 0; k < kN; ++k) {
    const double x = a.normal();
    ab += x * b.normal();
    ac += x * c.normal();
  }
  EXPECT_LT(std::abs(ab / kN), 4.0 / std::sqrt(kN));
  EXPECT_LT(std::abs(ac / kN), 4.0 / std::sqrt(kN));
}

TEST(Rng, uniform_is_uniformly_distributed_and_never_reaches_its_upper_bound) {
  Rng rng(1);
  std::array<int, 10> bins{};
  for (int k = 0; k < 20000; ++k) {
    const double u = rng.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++bins[static_cast<std::size_t>(u * 10.0)];
  }
  double chi2 = 0.0;
  for (const int n : bins) chi2 += (n - 2000.0) * (n - 2000.0) / 2000.0;
  EXPECT_LT(chi2, 27.9);  // 0.1 % of 9 degrees of freedom
  for (int k = 0; k < 1000; ++k) {
    const double u = rng.uniform(-3.0, -1.0);
    ASSERT_GE(u, -3.0);
    ASSERT_LT(u, -1.0);
  }
}

TEST(Rng, normal_has_the_moments_of_a_normal_variable) {
  Rng rng(2);
  constexpr int kN = 40000;
  std::array<double, 5> m{};
  double lag = 0.0;
  double last = 0.0;
  for (int k = 0; k < kN; ++k) {
    const double x = rng.normal();
    double power = 1.0;
    for (double& v : m) {
      v += power / kN;
      power *= x;
    }
    lag += x * last / kN;  // the two numbers of one Box-Muller pair must not be correlated
    last = x;
  }
  const double se = 1.0 / std::sqrt(kN);
  EXPECT_NEAR(m[1], 0.0, 4.0 * se);
  EXPECT_NEAR(m[2], 1.0, 4.0 * std::sqrt(2.0) * se);
  EXPECT_NEAR(m[3], 0.0, 4.0 * std::sqrt(15.0) * se);
  EXPECT_NEAR(m[4], 3.0, 4.0 * std::sqrt(96.0) * se);
  EXPECT_NEAR(lag, 0.0, 4.0 * se);
}

TEST(Rng, below_n_is_uniformly_distributed_and_less_than_n) {
  Rng rng(3);
  std::array<int, 7> counts{};
  for (int k = 0; k < 14000; ++k) {
    const std::uint64_t v = rng.below(7);
    ASSERT_LT(v, 7U);
    ++counts[v];
  }
  double chi2 = 0.0;
  for (const int n : counts) chi2 += (n - 2000.0) * (n - 2000.0) / 2000.0;
  EXPECT_LT(chi2, 22.5);  // 0.1 % of 6 degrees of freedom
  EXPECT_EQ(rng.below(1), 0U);
  // More than half of the numbers are rejected here; it must still terminate.
  EXPECT_LT(rng.below((1ULL << 63) + 1), (1ULL << 63) + 1);
}

TEST(Rng, below_zero_throws_an_internal_error) {
  Rng rng(4);
  EXPECT_THROW(static_cast<void>(rng.below(0)), InternalError);
}

}  // namespace
}  // namespace rali
