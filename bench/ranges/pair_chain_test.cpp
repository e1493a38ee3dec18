#include "pair_chain.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranges_bench {
namespace {

/// 60 s at 10 Hz from 3 to 9 m distance and back, constant error 0.1 m and white noise of 0.1 m.
PairRecord good_pair(std::uint64_t seed) {
  PairRecord pair;
  Rng rng(seed, "pair");
  for (int k = 0; k < 600; ++k) {
    PairRange r;
    r.t = Time::from_s(0.1 * k);
    r.true_m = 6.0 - 3.0 * std::cos(0.1 * k / 5.0);
    r.range_m = r.true_m + 0.1 + 0.1 * rng.normal();
    pair.ranges.push_back(r);
  }
  return pair;
}

ChainScores many(double position_sigma_m, void (*spoil)(PairRecord&)) {
  PairSet set;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    set.pairs.push_back(good_pair(seed));
    if (spoil != nullptr) spoil(set.pairs.back());
  }
  ChainOptions options;
  options.position_sigma_m = position_sigma_m;
  return run_chain(set, options);
}

TEST(PairChain, good_ranges_are_kept_and_their_offset_is_tracked_honestly) {
  for (const double sigma_m : {0.05, 0.3}) {
    const ChainScores s = many(sigma_m, nullptr);
    ASSERT_EQ(s.ranges, 12000u);
    EXPECT_GT(static_cast<double>(s.good_kept), 0.97 * static_cast<double>(s.good)) << sigma_m;
    const double nees = s.nees_offset / static_cast<double>(s.ranges);
    EXPECT_LT(nees, 1.5) << sigma_m;
    EXPECT_GT(nees, 0.3) << sigma_m;
  }
}

// A person obstructs the signal for 2 s, ranges are one metre too long: the chain's main purpose.
TEST(PairChain, a_blocked_path_is_refused) {
  const ChainScores s = many(0.05, [](PairRecord& pair) {
    for (int k = 300; k < 320; ++k) pair.ranges[static_cast<std::size_t>(k)].range_m += 1.0;
  });
  EXPECT_GE(s.bad, 400u);
  EXPECT_GT(static_cast<double>(s.bad_refused), 0.9 * 400.0);
  EXPECT_LT(std::sqrt(s.square_after / s.weight_after), 0.12);
  EXPECT_GT(std::sqrt(s.square_before_m2 / static_cast<double>(s.ranges)), 0.2);
}

TEST(PairChain, counts_add_up) {
  const ChainScores s = many(0.3, nullptr);
  EXPECT_EQ(s.bad + s.good, s.ranges);
  std::size_t all = 0;
  for (const std::size_t n : s.reasons) all += n;
  EXPECT_EQ(all, s.ranges);
  EXPECT_EQ(run_chain(PairRecord{}, 0, {}).ranges, 0u);
}

}  // namespace
}  // namespace rali::ranges_bench
