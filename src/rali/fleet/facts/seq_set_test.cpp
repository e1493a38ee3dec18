#include "rali/fleet/facts/seq_set.hpp"

#include <set>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::fleet {
namespace {

TEST(SeqSet, inserting_the_missing_number_merges_two_intervals) {
  SeqSet set;
  EXPECT_TRUE(set.insert(2));
  EXPECT_TRUE(set.insert(4));
  EXPECT_EQ(set.gaps(), (std::vector<SeqInterval>{{0, 1}, {3, 3}}));
  EXPECT_TRUE(set.insert(3));
  EXPECT_FALSE(set.insert(3));
  EXPECT_EQ(set.gaps(), (std::vector<SeqInterval>{{0, 1}}));
  EXPECT_EQ(set.end(), 5U);
  EXPECT_EQ(set.size(), 3U);
  EXPECT_EQ(set.first_gap(0), 0U);
  EXPECT_EQ(set.first_gap(2), std::nullopt);
}

TEST(SeqSet, agrees_with_std_set_for_random_insertions) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed);
    SeqSet set, other;
    std::set<std::uint32_t> plain, plain_other;
    for (int k = 0; k < 60; ++k) {
      const auto seq = static_cast<std::uint32_t>(rng.below(50));
      SeqSet copy = set;
      copy.insert(seq);
      EXPECT_EQ(set.gap_count_with(seq), copy.gap_count());
      EXPECT_EQ(copy.gap_count(), copy.gaps().size());
      EXPECT_EQ(set.insert(seq), plain.insert(seq).second);
      const auto second = static_cast<std::uint32_t>(rng.below(50));
      other.insert(second);
      plain_other.insert(second);
    }
    for (std::uint32_t seq = 0; seq < 60; ++seq) {
      EXPECT_EQ(set.contains(seq), plain.count(seq) == 1);
      std::optional<std::uint32_t> lacking, gap;
      for (std::uint32_t s = 60; s-- > seq;) {
        if (plain_other.count(s) == 1 && plain.count(s) == 0) lacking = s;
        if (s < set.end() && plain.count(s) == 0) gap = s;
      }
      EXPECT_EQ(set.first_lacking(other, seq), lacking);
      EXPECT_EQ(set.first_gap(seq), gap);
    }
  }
}

TEST(SeqSet, is_restored_from_an_inventory_and_truncated_at_contradictory_gaps) {
  SeqSet set;
  for (const std::uint32_t seq : {1U, 2U, 6U}) set.insert(seq);
  const StreamInventory reported{{VehicleId{1}, 0}, 7, set.gaps()};
  const SeqSet back = SeqSet::from(reported);
  EXPECT_EQ(back.gaps(), set.gaps());
  EXPECT_EQ(back.end(), 7U);
  const SeqSet odd = SeqSet::from({{VehicleId{1}, 0}, 10, {{4, 5}, {3, 8}}});
  EXPECT_EQ(odd.end(), 4U);
}

}  // namespace
}  // namespace rali::fleet
