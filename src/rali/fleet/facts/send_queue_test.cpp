#include "rali/fleet/facts/send_queue.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/fleet/facts/quantise.hpp"

namespace rali::fleet {
namespace {

const VehicleId kA{1};

FactPtr fact(std::uint32_t seq, FactBody body, double t_s = 0.0) {
  return std::make_shared<const Fact>(Fact{{kA, 0, seq}, Time::from_s(t_s), std::move(body)});
}

FactPtr increment(std::uint32_t seq, double t_s = 0.0) { return fact(seq, Increment{}, t_s); }

KeyframePoints points(bool refinement) {
  KeyframePoints p;
  p.refinement = refinement;
  return p;
}

std::vector<std::uint32_t> numbers(const std::vector<FactPtr>& facts) {
  std::vector<std::uint32_t> out;
  for (const FactPtr& f : facts) out.push_back(f->key.seq);
  return out;
}

Holdings has(const std::vector<std::uint32_t>& seqs) {
  Holdings holdings;
  for (const std::uint32_t seq : seqs) holdings[{kA, 0}].insert(seq);
  return holdings;
}

TEST(SendQueue, sends_ranges_and_increments_first_and_fine_points_last) {
  SendQueue queue{{}};
  queue.add(fact(0, points(true), 1.0), false);
  queue.add(fact(1, points(false), 1.0), false);
  queue.add(fact(2, Loop{}, 1.0), false);
  queue.add(increment(3, 3.0), false);
  queue.add(fact(4, RangeBlock{}, 2.0), false);
  EXPECT_EQ(numbers(queue.take(Time{})), (std::vector<std::uint32_t>{4, 3, 2, 1, 0}));
  EXPECT_EQ(queue.size(), 0U);
}

TEST(SendQueue, sends_no_faster_than_its_rate) {
  ExchangeSettings settings;
  settings.rate_first_Bps = 8000.0;
  SendQueue queue(settings);
  for (std::uint32_t seq = 0; seq < 100; ++seq) queue.add(increment(seq), false);
  const auto size = static_cast<double>(bytes_about(*increment(0)));
  // Half a second's 4000 bytes at once, and then 800 in each tenth of a second.
  EXPECT_EQ(static_cast<double>(queue.take(Time{}).size()), std::ceil(4000.0 / size));
  std::size_t sent = 0;
  for (int k = 1; k <= 10; ++k) sent += queue.take(Time::from_s(0.1 * k)).size();
  EXPECT_NEAR(static_cast<double>(sent), 8000.0 / size, 1.1);
}

TEST(SendQueue, sends_requested_facts_within_the_credit_and_new_facts_without_credit) {
  SendQueue queue{{}};
  for (std::uint32_t seq = 0; seq < 3; ++seq) queue.add(increment(seq), true);
  queue.add(increment(9), false);
  EXPECT_EQ(numbers(queue.take(Time{})), (std::vector<std::uint32_t>{9}));
  queue.grant(1.0);
  EXPECT_EQ(numbers(queue.take(Time{})), (std::vector<std::uint32_t>{0}));
  queue.grant(1000.0);
  EXPECT_EQ(queue.take(Time{}).size(), 2U);
}

TEST(SendQueue, does_not_send_facts_that_the_receivers_inventory_lists) {
  SendQueue queue{{}};
  for (std::uint32_t seq = 0; seq < 4; ++seq) queue.add(increment(seq), false);
  queue.confirm(has({1, 2}), Time{});
  EXPECT_EQ(numbers(queue.take(Time{})), (std::vector<std::uint32_t>{0, 3}));
}

TEST(SendQueue, raises_the_rate_without_loss_and_lowers_it_after_loss) {
  ExchangeSettings settings;
  settings.rate_first_Bps = 40000.0;
  SendQueue queue(settings);
  for (std::uint32_t seq = 0; seq < 300; ++seq) queue.add(increment(seq), false);
  const std::size_t first = queue.take(Time{}).size();
  queue.confirm(has({}), Time::from_s(1.0));  // nothing is overdue yet
  EXPECT_EQ(queue.rate_Bps(), 40000.0);
  std::vector<std::uint32_t> all(first);
  for (std::uint32_t k = 0; k < first; ++k) all[k] = k;
  queue.confirm(has(all), Time::from_s(5.0));
  EXPECT_EQ(queue.rate_Bps(), 60000.0) << "all came over a full link: more is tried";
  const std::size_t second = queue.take(Time::from_s(5.1)).size();
  ASSERT_GT(second, 20U);
  // Ten seconds later, 10 of those facts have arrived: 0.7 * 10 * 400 B / 10 s.
  for (std::uint32_t k = 0; k < 10; ++k) all.push_back(static_cast<std::uint32_t>(first) + k);
  queue.add(increment(1000), false);
  queue.confirm(has(all), Time::from_s(15.0));
  EXPECT_NEAR(queue.rate_Bps(), settings.rate_min_Bps, 1.0);
}

}  // namespace
}  // namespace rali::fleet
