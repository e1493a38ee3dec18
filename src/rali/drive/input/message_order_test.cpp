#include "rali/drive/input/message_order.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::drive {
namespace {

using Stamps = std::vector<StampPair>;

/// 10 Hz; the recorder is 20 ms late, and for some messages a little more.
Stamps steady(double start_s, int n) {
  Stamps stamps;
  for (int i = 0; i < n; ++i) {
    const double t_s = start_s + 0.1 * i;
    stamps.push_back({Time::from_s(t_s), Time::from_s(t_s + 0.02 + (i % 7 == 3 ? 0.03 : 0.0))});
  }
  return stamps;
}

Stamps shuffled(Stamps stamps) {
  Rng rng(3);
  for (std::size_t i = stamps.size(); i > 1; --i) {
    std::swap(stamps[i - 1], stamps[rng.below(i)]);
  }
  return stamps;
}

/// The headers keep their order, the record times rise.
Stamps recorded_anew(Stamps stamps) {
  const Stamps clock = steady(5000.0, static_cast<int>(stamps.size()));
  for (std::size_t i = 0; i < stamps.size(); ++i) stamps[i].record = clock[i].record;
  return stamps;
}

Stamps recorded_at_once(Stamps stamps) {
  for (StampPair& pair : stamps) pair.record = Time::from_s(5000.0);
  return stamps;
}

Stamps joined(Stamps a, const Stamps& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

MessageOrder order_of(const Stamps& stamps) { return decide_message_order(stamps); }

TEST(MessageOrder, steady_and_slightly_mixed_messages_keep_the_file_order) {
  Stamps stamps = steady(100.0, 200);
  EXPECT_EQ(order_of(stamps), MessageOrder::kFile);
  for (std::size_t i = 0; i + 3 < stamps.size(); i += 6) std::swap(stamps[i], stamps[i + 3]);
  EXPECT_EQ(order_of(stamps), MessageOrder::kFile) << "the ordering window sorts them";
  EXPECT_EQ(order_of({}), MessageOrder::kFile);
  EXPECT_EQ(order_of(joined(steady(100.0, 50), steady(170.0, 50))), MessageOrder::kFile);
}

TEST(MessageOrder, reversed_and_shuffled_messages_are_sorted_by_record_time) {
  Stamps stamps = steady(100.0, 200);
  EXPECT_EQ(order_of(shuffled(stamps)), MessageOrder::kRecordTime);
  std::reverse(stamps.begin(), stamps.end());
  EXPECT_EQ(order_of(stamps), MessageOrder::kRecordTime);
  const Stamps with_pauses = joined(steady(100.0, 60), steady(150.0, 60));
  EXPECT_EQ(order_of(shuffled(with_pauses)), MessageOrder::kRecordTime);
}

TEST(MessageOrder, swapped_blocks_are_sorted_by_record_time) {
  EXPECT_EQ(order_of(joined(steady(110.0, 100), steady(100.0, 100))), MessageOrder::kRecordTime);
  const Stamps inner = joined(steady(130.0, 100), steady(110.0, 200));
  EXPECT_EQ(order_of(joined(joined(steady(100.0, 100), inner), steady(140.0, 100))),
            MessageOrder::kRecordTime);
}

TEST(MessageOrder, a_clock_set_back_is_not_treated_as_disorder) {
  EXPECT_EQ(order_of(joined(steady(100.0, 200), steady(117.04, 200))), MessageOrder::kClockSet)
      << "by 3 s: these times came twice";
  EXPECT_EQ(order_of(joined(steady(100.0, 20), steady(50.0, 300))), MessageOrder::kClockSet)
      << "before the start: sorting would leave a gap";
  EXPECT_EQ(order_of(joined(steady(1.7e9, 50), steady(3.0, 300))), MessageOrder::kClockSet);
}

TEST(MessageOrder, headers_decide_if_record_times_carry_no_order) {
  const Stamps stamps = steady(100.0, 200);
  for (const Stamps& lost : {recorded_anew(shuffled(stamps)), recorded_at_once(shuffled(stamps))}) {
    EXPECT_EQ(order_of(lost), MessageOrder::kHeader);
  }
  EXPECT_EQ(order_of(recorded_at_once(stamps)), MessageOrder::kFile);
  EXPECT_EQ(order_of(recorded_anew(joined(steady(100.0, 100), steady(107.03, 100)))),
            MessageOrder::kFile)
      << "the stream shows that the header's clock was set";
}

TEST(MessageOrder, headers_in_order_outweigh_record_times_out_of_order) {
  Stamps stamps = steady(100.0, 200);
  const Stamps mixed = shuffled(stamps);
  for (std::size_t i = 0; i < stamps.size(); ++i) stamps[i].record = mixed[i].record;
  EXPECT_EQ(order_of(stamps), MessageOrder::kFile);
}

TEST(MessageOrder, invalid_header_stamps_are_not_used_for_sorting) {
  Stamps stamps = steady(1000.0, 200);
  for (std::size_t i = 0; i < stamps.size(); i += 2) stamps[i].header = Time::from_s(3.0);
  EXPECT_EQ(order_of(stamps), MessageOrder::kFile);
  for (StampPair& pair : stamps) pair.header = Time{};
  EXPECT_EQ(order_of(stamps), MessageOrder::kFile);
  EXPECT_EQ(order_of(shuffled(stamps)), MessageOrder::kRecordTime) << "the recorder's times do";
}

TEST(MessageOrder, topics_written_one_after_the_other_are_sorted_together) {
  std::vector<TopicStamp> stamps;
  for (const std::size_t topic : {0U, 1U}) {
    for (const StampPair& pair : steady(100.0, 100)) stamps.push_back({topic, topic == 1, pair});
  }
  EXPECT_EQ(decide_message_order(stamps), MessageOrder::kRecordTime);
  for (TopicStamp& s : stamps) s.stamp.record = Time::from_s(7.0);
  EXPECT_EQ(decide_message_order(stamps), MessageOrder::kHeader);
  std::stable_sort(stamps.begin(), stamps.end(), [](const TopicStamp& a, const TopicStamp& b) {
    return a.stamp.header < b.stamp.header;
  });
  EXPECT_EQ(decide_message_order(stamps), MessageOrder::kFile);
}

TEST(MessageOrder, handles_extreme_stamp_values) {
  Stamps stamps;
  for (const std::int64_t ns : {INT64_MAX, INT64_MIN, std::int64_t{7}, INT64_MAX, INT64_MIN + 1}) {
    stamps.push_back({Time{ns}, Time{~ns}});
  }
  (void)order_of(stamps);
  SUCCEED() << "the sanitizers watch";
}

}  // namespace
}  // namespace rali::drive
