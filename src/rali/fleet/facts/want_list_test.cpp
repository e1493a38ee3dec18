#include "rali/fleet/facts/want_list.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

constexpr VehicleId kSelf{0}, kPeer{1};
const Time kNow = Time::from_s(10.0);
constexpr std::uint32_t kLast = 0xFFFFFFFFU;

/// A vehicle without facts, and a peer that lists the first numbers of some streams.
struct Lacking {
  void peer_has(std::uint32_t epoch, std::uint32_t end) {
    theirs[{kPeer, epoch}] = SeqSet::from({{kPeer, epoch}, end, {}});
  }

  void refresh() { wants.refresh(store, {{kPeer, &theirs}}, withheld, kNow); }

  FactStore store{kSelf, {kSelf, kPeer}};
  Holdings theirs, withheld;
  WantList wants{ExchangeSettings{}};
};

TEST(WantList, skips_an_interval_of_four_billion_withheld_numbers) {
  Lacking me;
  me.peer_has(0, kLast);
  me.withheld[{kPeer, 0}] = SeqSet::from({{kPeer, 0}, kLast - 2, {{5, 6}}});
  me.refresh();
  EXPECT_EQ(me.wants.size(), 4U);  // 5, 6, and the two after the withheld ones
}

TEST(WantList, does_not_overflow_after_the_last_number) {
  Lacking me;
  me.peer_has(0, kLast);
  me.theirs[{kPeer, 0}].insert(kLast);
  me.withheld[{kPeer, 0}] = me.theirs[{kPeer, 0}];
  me.refresh();
  EXPECT_EQ(me.wants.size(), 0U);
}

TEST(WantList, requests_the_first_512_numbers_of_each_of_32_streams) {
  Lacking me;
  for (std::uint32_t epoch = 0; epoch < 32; ++epoch) me.peer_has(epoch, 100000);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 32U * 512U);
}

TEST(WantList, requests_16_numbers_from_each_of_1023_streams_without_omitting_another) {
  Lacking me;
  for (std::uint32_t epoch = 0; epoch < 1023; ++epoch) me.peer_has(epoch, kLast);
  me.peer_has(5000, 3);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 1023U * 16U + 3U);
}

TEST(WantList, requests_one_number_from_each_of_20000_streams) {
  Lacking me;
  for (std::uint32_t epoch = 0; epoch < 20000; ++epoch) me.peer_has(epoch, 2);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 20000U);
}

FactPtr fact_of(std::uint32_t epoch, std::uint32_t seq) {
  return std::make_shared<const Fact>(Fact{{kPeer, epoch, seq}, kNow, EpochStart{}});
}

// A fact held only by its author, and not on its disk when it stopped, stayed wanted for ever. A
// mission that waits for all facts would never have ended.
TEST(WantList, requests_facts_lost_in_a_restart_only_if_a_peer_has_them) {
  Lacking me;
  me.store.add(fact_of(0, 0));
  me.store.add(fact_of(0, 3));
  me.peer_has(0, 1);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 2U) << "1 and 2: their author has all below 3, it need not say so";
  me.peer_has(1, 1);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 1U) << "the first fact of its new epoch";
  me.theirs[{kPeer, 0}] = SeqSet::from({{kPeer, 0}, 3, {{1, 1}}});
  me.refresh();
  EXPECT_EQ(me.wants.size(), 2U) << "2 has been kept";
}

}  // namespace
}  // namespace rali::fleet
