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
  settings.heard_s = 6.0;
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
  fleet.run_until(agreed_at_s + 20.0);  // and nothing is sent for nothing
  bool complete = fleet.agree();
  for (std::uint16_t v = 0; v < 3; ++v) {
    complete = complete && fleet.store(v).size() == 300 && fleet.delivered(v) == 300;
  }
  return {complete, static_cast<double>(fleet.facts_sent()) / 600.0, agreed_at_s};
}

TEST(Exchange, all_vehicles_get_all_facts_once_through_loss_and_a_partition) {
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

}  // namespace
}  // namespace rali::drive
