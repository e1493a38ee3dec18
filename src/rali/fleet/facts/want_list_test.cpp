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

TEST(WantList, four_billion_numbers_kept_back_are_passed_over_at_once) {
  Lacking me;
  me.peer_has(0, kLast);
  me.withheld[{kPeer, 0}] = SeqSet::from({{kPeer, 0}, kLast - 2, {{5, 6}}});
  me.refresh();
  EXPECT_EQ(me.wants.size(), 4U);  // 5, 6, and the two after the withheld ones
}

TEST(WantList, nothing_comes_after_the_last_number) {
  Lacking me;
  me.peer_has(0, kLast);
  me.theirs[{kPeer, 0}].insert(kLast);
  me.withheld[{kPeer, 0}] = me.theirs[{kPeer, 0}];
  me.refresh();
  EXPECT_EQ(me.wants.size(), 0U);
}

TEST(WantList, of_few_streams_the_first_512_numbers_are_wanted) {
  Lacking me;
  for (std::uint32_t epoch = 0; epoch < 32; ++epoch) me.peer_has(epoch, 100000);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 32U * 512U);
}

TEST(WantList, a_thousand_streams_that_nobody_has_neither_grow_it_nor_hide_a_true_one) {
  Lacking me;
  for (std::uint32_t epoch = 0; epoch < 1023; ++epoch) me.peer_has(epoch, kLast);
  me.peer_has(5000, 3);
  me.refresh();
  EXPECT_EQ(me.wants.size(), 1023U * 16U + 3U);
}

TEST(WantList, more_streams_than_numbers_leave_one_number_to_each) {
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
TEST(WantList, what_an_author_lost_in_a_restart_is_wanted_only_where_somebody_has_it) {
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
