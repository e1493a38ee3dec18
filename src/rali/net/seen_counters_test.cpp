#include "rali/net/seen_counters.hpp"

#include <gtest/gtest.h>

namespace rali::net {
namespace {

TEST(SeenCounters, survive_a_round_trip_and_truncated_rows_are_refused) {
  const std::vector<SeenCounter> seen = {{{3}, true, Urgency::kRole, 7, 1ULL << 40},
                                         {{65}, false, Urgency::kStatus, 0, 1}};
  const std::vector<std::byte> bytes = encode_seen(seen);
  EXPECT_EQ(bytes.size(), 33U);
  EXPECT_EQ(decode_seen(bytes), seen);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = decode_seen(std::span(bytes).first(size));
    EXPECT_EQ(cut.has_value(), size % 16 == 1) << size << ": whole rows";
  }
  auto newer = bytes;
  newer[0] = std::byte{2};
  EXPECT_FALSE(decode_seen(newer).has_value());
  auto other = bytes;
  other[4] = std::byte{9};
  EXPECT_FALSE(decode_seen(other).has_value()) << "no such urgency";
}

TEST(SeenCounters, of_a_fleet_of_64_fit_a_slot) {
  const std::vector<SeenCounter> all(63 * 4);
  EXPECT_EQ(decode_seen(encode_seen(all))->size(), all.size());
  EXPECT_LE(encode_seen(std::vector<SeenCounter>(1000)).size(), 4096U - 24U);
}

}  // namespace
}  // namespace rali::net
