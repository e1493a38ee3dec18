#include <gtest/gtest.h>

#include "rali/fleet/facts/exchange.hpp"

namespace rali::fleet {
namespace {

constexpr VehicleId kSelf{0}, kPeer{1};

/// A tag that takes no points, and the peer that reports which ones it withholds.
struct Tag {
  Tag() { exchange.set_points_to(kPeer); }

  void receive(Message message) {
    exchange.receive(Envelope{kPeer, std::nullopt, std::move(message)}, store, now);
  }

  /// Facts requested when the peer lists the first numbers of one stream.
  std::size_t lacking(std::uint32_t epoch, std::uint32_t facts) {
    receive(Inventory{++inventory, 0, {{{kPeer, epoch}, facts, {}}}});
    static_cast<void>(exchange.step(store, now));
    return exchange.lacking();
  }

  FactStore store{kSelf, {kSelf, kPeer}};
  Exchange exchange{kSelf, {kSelf, kPeer}, {}};
  Time now = Time::from_s(10.0);
  std::uint32_t inventory = 0;
};

TEST(ExchangeBounds, withheld_facts_are_not_requested) {
  Tag tag;
  tag.receive(Withheld{{kPeer, 3}, {{0, 1}}});
  EXPECT_EQ(tag.lacking(3, 3), 1U);
}

TEST(ExchangeBounds, the_number_of_streams_with_withheld_facts_is_bounded) {
  Tag tag;
  for (std::uint32_t epoch = 0; epoch < 3000; ++epoch)
    tag.receive(Withheld{{kPeer, epoch}, {{0, 0}}});
  EXPECT_EQ(tag.lacking(1000, 1), 0U);
  EXPECT_EQ(tag.lacking(2999, 1), 1U);
}

TEST(ExchangeBounds, the_gaps_of_withheld_numbers_are_bounded_per_stream) {
  Tag tag;
  for (std::uint32_t seq = 1; seq < 20000; seq += 2)
    tag.receive(Withheld{{kPeer, 0}, {{seq, seq}}});
  tag.receive(Withheld{{kPeer, 1}, {{0, 0}}});
  EXPECT_EQ(tag.lacking(0, 2), 1U);  // number 0; 1 is withheld
  EXPECT_EQ(tag.lacking(1, 1), 0U);  // another stream is not affected
}

}  // namespace
}  // namespace rali::fleet
