#include "rali/drive/link/loopback.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/link/post.hpp"

namespace rali::drive {
namespace {

const VehicleId kA{0}, kB{1}, kC{2};

Time at(double s) { return Time::from_s(s); }

wire::Bytes message(std::size_t size, int mark = 0) {
  wire::Bytes bytes(size, std::byte{0});
  bytes.back() = static_cast<std::byte>(mark);
  return bytes;
}

int mark_of(const Delivery& delivery) { return std::to_integer<int>(delivery.bytes->back()); }

TEST(Loopback, delays_a_message_by_its_transmission_time_and_the_latency) {
  LinkSettings settings;
  settings.rate_Bps = 1000.0;
  settings.delay_s = 0.5;
  Loopback radio({kA, kB}, settings, 1);
  radio.send(at(10.0), kA, kB, message(200, 1));
  radio.send(at(10.0), kA, kB, message(300, 2));
  // 200 B take 0.2 s, the next 300 B start after them: 10.7 s and 11.0 s.
  EXPECT_TRUE(radio.deliver(at(10.69)).empty());
  const auto first = radio.deliver(at(10.7));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(mark_of(first[0]), 1);
  const auto second = radio.deliver(at(20.0));
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].t, at(11.0));
  EXPECT_TRUE(radio.deliver(at(99.0)).empty());
}

TEST(Loopback, a_full_queue_drops_the_newest_messages) {
  LinkSettings settings;
  settings.rate_Bps = 1000.0;
  settings.queue_bytes = 1500.0;
  Loopback radio({kA, kB}, settings, 1);
  for (int k = 0; k < 5; ++k) radio.send(at(0.0), kA, kB, message(500, k));
  const auto arrived = radio.deliver(at(100.0));
  ASSERT_EQ(arrived.size(), 3U);
  EXPECT_EQ(mark_of(arrived[2]), 2);
  EXPECT_EQ(radio.sent().total().bytes, 2500U) << "sent is counted, whatever becomes of it";
  EXPECT_EQ(radio.arrived().total().bytes, 1500U);
}

TEST(Loopback, a_broadcast_uses_each_link_separately) {
  Loopback radio({kA, kB, kC}, LinkSettings{}, 1);
  LinkSettings slow;
  slow.delay_s = 2.0;
  radio.set_link(kA, kC, slow);
  radio.send(at(0.0), kA, std::nullopt, message(10));
  EXPECT_EQ(radio.deliver(at(1.0)).size(), 1U);
  const auto late = radio.deliver(at(2.0));
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].to, kC);
  EXPECT_EQ(radio.reported(kA).total().messages, 1U) << "said once, sent to each";
  EXPECT_EQ(radio.reported(kB).total().messages, 0U);
  EXPECT_EQ(radio.sent(kA, kB).total().messages, 1U);
  EXPECT_EQ(radio.sent(kB, kA).total().messages, 0U);
}

TEST(Loopback, loss_and_duplication_rates_are_as_configured) {
  LinkSettings settings;
  settings.loss = 0.3;
  settings.duplication = 0.1;
  settings.jitter_s = 2.0;
  Loopback radio({kA, kB}, settings, 7);
  constexpr int kMessages = 10000;
  for (int k = 0; k < kMessages; ++k) radio.send(at(0.001 * k), kA, kB, message(10, k % 256));
  const auto arrived = radio.deliver(at(100.0));
  // 0.7 * 1.1 = 0.77 of them; 4 sd of the count are 1.8 %, repetitions included.
  EXPECT_NEAR(static_cast<double>(arrived.size()) / kMessages, 0.77, 0.02);
  const bool in_time = std::is_sorted(arrived.begin(), arrived.end(),
                                      [](const auto& a, const auto& b) { return a.t < b.t; });
  EXPECT_TRUE(in_time);
  int overtaken = 0;
  for (std::size_t k = 1; k < arrived.size(); ++k) {
    overtaken += (mark_of(arrived[k]) - mark_of(arrived[k - 1]) + 256) % 256 > 128 ? 1 : 0;
  }
  EXPECT_GT(overtaken, kMessages / 10) << "jitter must let messages overtake each other";
}

TEST(Loopback, is_deterministic_per_seed_even_after_an_outage) {
  LinkSettings settings;
  settings.loss = 0.3;
  settings.duplication = 0.2;
  settings.reordering = 0.2;
  settings.jitter_s = 0.3;
  const auto run = [&settings](std::uint64_t seed, bool cut) {
    Loopback radio({kA, kB}, settings, seed);
    if (cut) radio.cut_off(kB, at(2.0), at(3.0));
    std::vector<std::pair<Time, int>> got;
    for (int k = 0; k < 100; ++k) radio.send(at(0.1 * k), kA, kB, message(10, k));
    for (const Delivery& d : radio.deliver(at(99.0))) {
      if (mark_of(d) < 20 || mark_of(d) >= 30) got.emplace_back(d.t, mark_of(d));
    }
    return got;
  };
  EXPECT_EQ(run(1, false), run(1, false));
  EXPECT_NE(run(1, false), run(2, false));
  EXPECT_EQ(run(1, false), run(1, true));
}

TEST(Loopback, an_outage_affects_only_its_direction_and_interval) {
  Loopback radio({kA, kB}, LinkSettings{}, 1);
  radio.cut(kA, kB, at(10.0), at(20.0));
  const auto arrives = [&radio](double t_s, VehicleId from, VehicleId to) {
    radio.send(at(t_s), from, to, message(10));
    return radio.deliver(at(t_s)).size() == 1;
  };
  EXPECT_TRUE(arrives(9.9, kA, kB));
  EXPECT_FALSE(arrives(10.0, kA, kB));
  EXPECT_TRUE(arrives(15.0, kB, kA));
  EXPECT_FALSE(radio.connected(kA, kB, at(15.0)));
  EXPECT_TRUE(arrives(20.0, kA, kB));
}

TEST(Loopback, a_killed_vehicle_neither_sends_nor_receives) {
  LinkSettings settings;
  settings.delay_s = 1.0;
  Loopback radio({kA, kB}, settings, 1);
  radio.send(at(0.0), kA, kB, message(10));
  radio.send(at(0.0), kB, kA, message(10));
  radio.kill(kB);
  radio.send(at(0.5), kB, kA, message(10));
  const auto arrived = radio.deliver(at(5.0));
  ASSERT_EQ(arrived.size(), 1U) << "what it sent before is on its way";
  EXPECT_EQ(arrived[0].to, kA);
  radio.revive(kB);
  radio.send(at(6.0), kA, kB, message(10));
  EXPECT_EQ(radio.deliver(at(7.0)).size(), 1U);
}

TEST(Post, delivers_a_decoded_message_and_counts_undecodable_ones) {
  Loopback radio({kA, kB}, LinkSettings{}, 1);
  fleet::RoleMessage role;
  role.term = 12;
  ASSERT_TRUE(post(radio, at(1.0), {kA, kB, role}));
  radio.send(at(1.0), kA, kB, message(40));
  const Mail mail = collect(radio, at(1.0));
  ASSERT_EQ(mail.received.size(), 1U);
  EXPECT_EQ(mail.received[0].to, kB);
  EXPECT_EQ(std::get<fleet::RoleMessage>(mail.received[0].envelope.message).term, 12U);
  EXPECT_EQ(mail.unreadable, 1U);
  EXPECT_EQ(radio.sent()[fleet::Kind::kRole].messages, 1U);
}

}  // namespace
}  // namespace rali::drive
