#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/link/vehicles_for_test.hpp"

namespace rali::drive {
namespace {

LinkSettings bad_radio() {
  LinkSettings link;
  link.loss = 0.3;
  link.duplication = 0.1;
  link.jitter_s = 2.0;
  return link;
}

/// T25: no status is sent here, so that inventories alone show that a link is up.
fleet::ExchangeSettings t25_settings() {
  fleet::ExchangeSettings settings;
  settings.received_s = 6.0;
  return settings;
}

struct Outcome {
  bool agree = false;
  double copies = 0.0;
  double agreed_at_s = 0.0;
};

Outcome run_t25(std::uint64_t seed) {
  TestFleet fleet(3, bad_radio(), seed, t25_settings());
  fleet.radio.cut_off(VehicleId{0}, Time::from_s(10.0), Time::from_s(70.0));
  for (int fact = 0; fact < 100; ++fact) {
    for (std::uint16_t v = 0; v < 3; ++v) fleet.make_fact(VehicleId{v});
    fleet.run_until(0.5 * (fact + 1));
  }
  while (fleet.now().s() < 300.0 && !fleet.agree()) fleet.step();
  const double agreed_at_s = fleet.now().s();
  fleet.run_until(agreed_at_s + 20.0);  // and no needless messages are sent
  bool complete = fleet.agree();
  for (std::uint16_t v = 0; v < 3; ++v) {
    complete = complete && fleet.store(v).size() == 300 && fleet.delivered(v) == 300;
  }
  return {complete, static_cast<double>(fleet.facts_sent()) / 600.0, agreed_at_s};
}

TEST(Exchange, delivers_every_fact_to_all_vehicles_despite_loss_and_a_partition) {
  double worst = 0.0, sum = 0.0, latest_s = 0.0;
  constexpr int kSeeds = 4;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Outcome outcome = run_t25(static_cast<std::uint64_t>(seed));
    EXPECT_TRUE(outcome.agree) << "seed " << seed;
    worst = std::max(worst, outcome.copies);
    sum += outcome.copies;
    latest_s = std::max(latest_s, outcome.agreed_at_s);
  }
  RecordProperty("copies_mean", std::to_string(sum / kSeeds));
  RecordProperty("copies_max", std::to_string(worst));
  RecordProperty("agreed_at_s", std::to_string(latest_s));
  EXPECT_LE(worst, 2.2) << "copies sent per fact and receiver";
  EXPECT_GT(worst, 1.0) << "every receiver needs one copy";
}

TEST(Exchange, over_a_good_link_each_fact_is_sent_once_to_each) {
  LinkSettings link;
  link.delay_s = 0.02;
  TestFleet fleet(3, link, 1, {});
  fleet.run_until(6.0);  // all have received messages from each other
  for (int k = 0; k < 40; ++k) {
    fleet.make_fact(VehicleId{0});
    fleet.run_until(6.0 + 0.5 * (k + 1));
  }
  fleet.run_until(40.0);
  EXPECT_TRUE(fleet.agree());
  EXPECT_EQ(fleet.facts_sent(), 2U * 40U);
}

TEST(Exchange, a_third_vehicle_forwards_facts_between_two_without_a_link) {
  TestFleet fleet(3, LinkSettings{}, 1, {});
  fleet.radio.cut(VehicleId{0}, VehicleId{2}, Time::from_s(0.0), Time::from_s(1000.0));
  fleet.radio.cut(VehicleId{2}, VehicleId{0}, Time::from_s(0.0), Time::from_s(1000.0));
  for (int k = 0; k < 20; ++k) {
    fleet.make_fact(VehicleId{0});
    fleet.make_fact(VehicleId{2});
    fleet.run_until(0.5 * (k + 1));
  }
  fleet.run_until(40.0);
  EXPECT_TRUE(fleet.agree());
  EXPECT_EQ(fleet.store(2).size(), 40U);
}

TEST(Exchange, facts_of_a_dead_vehicle_are_sent_by_its_peers) {
  TestFleet fleet(3, LinkSettings{}, 1, {});
  fleet.radio.cut(VehicleId{0}, VehicleId{2}, Time::from_s(0.0), Time::from_s(1000.0));
  fleet.radio.cut_off(VehicleId{2}, Time::from_s(0.0), Time::from_s(30.0));
  for (int k = 0; k < 20; ++k) {
    fleet.make_fact(VehicleId{0});
    fleet.run_until(0.5 * (k + 1));
  }
  fleet.run_until(20.0);
  EXPECT_EQ(fleet.store(1).size(), 20U);
  EXPECT_EQ(fleet.store(2).size(), 0U);
  fleet.radio.kill(VehicleId{0});
  fleet.run_until(60.0);
  EXPECT_EQ(fleet.store(2).size(), 20U);
}

TEST(Exchange, sends_points_only_to_the_anchor_until_the_round_ends) {
  LinkSettings link;
  link.loss = 0.1;
  TestFleet fleet(3, link, 1, {});
  const VehicleId anchor{1};
  for (std::uint16_t v = 0; v < 3; ++v) fleet.exchange(v).set_points_to(anchor);
  fleet.run_until(6.0);
  for (int k = 0; k < 30; ++k) {
    fleet.make_fact(VehicleId{0});
    fleet.run_until(6.0 + 0.5 * (k + 1));
  }
  fleet.run_until(60.0);
  EXPECT_EQ(fleet.store(1).size(), 30U);
  EXPECT_EQ(fleet.store(2).size(), 21U) << "of 30 facts 9 are points";
  const std::uint64_t requests = fleet.radio.sent()[fleet::Kind::kRequest].messages;
  fleet.run_until(90.0);
  EXPECT_EQ(fleet.radio.sent()[fleet::Kind::kRequest].messages, requests)
      << "points that are kept back are asked for again and again";
  for (std::uint16_t v = 0; v < 3; ++v) fleet.exchange(v).set_points_to(std::nullopt);
  fleet.run_until(120.0);
  EXPECT_TRUE(fleet.agree());
}

TEST(Exchange, a_narrow_link_transfers_increments_before_points_and_finally_everything) {
  LinkSettings narrow;
  narrow.rate_Bps = 3000.0;
  narrow.queue_bytes = 8000.0;
  fleet::ExchangeSettings settings;
  settings.rate_first_Bps = 2500.0;
  TestFleet fleet(2, narrow, 1, settings);
  fleet.run_until(6.0);
  for (int k = 0; k < 60; ++k) fleet.make_fact(VehicleId{0});
  std::size_t increments = 0, points = 0;
  while (fleet.now().s() < 100.0 && increments < 20) {
    fleet.step();
    increments = points = 0;
    fleet.store(1).for_each({VehicleId{0}, 0}, 0, 59, [&](const fleet::FactPtr& fact) {
      increments += std::holds_alternative<fleet::Increment>(fact->body) ? 1 : 0;
      points += std::holds_alternative<fleet::KeyframePoints>(fact->body) ? 1 : 0;
      return true;
    });
  }
  EXPECT_EQ(increments, 20U);
  EXPECT_EQ(points, 0U) << "points before increments";
  while (fleet.now().s() < 200.0 && !fleet.agree()) fleet.step();
  EXPECT_TRUE(fleet.agree());
}

}  // namespace
}  // namespace rali::drive
