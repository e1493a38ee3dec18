#include "rali/fleet/facts/fact_store.hpp"

#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "rali/fleet/facts/facts_for_test.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace rali::fleet {
namespace {

const VehicleId kA{1}, kB{2};

FactPtr fact(VehicleId vehicle, std::uint32_t seq, double value = 0.0, std::uint32_t epoch = 0) {
  Increment step;
  step.T_odom_body.p.x() = value;
  return std::make_shared<const Fact>(Fact{{vehicle, epoch, seq}, Time::from_s(seq), step});
}

TEST(FactStore, a_repeated_fact_is_delivered_once) {
  FactStore store(kA, {kA, kB});
  EXPECT_EQ(store.add(fact(kB, 0)), FactStore::Added::kNew);
  EXPECT_EQ(store.add(fact(kB, 0)), FactStore::Added::kKnown);
  EXPECT_EQ(store.take_new().size(), 1U);
  EXPECT_EQ(store.add(fact(kB, 0)), FactStore::Added::kKnown);
  EXPECT_TRUE(store.take_new().empty());
  EXPECT_TRUE(store.take_findings().empty());
}

TEST(FactStore, reports_different_content_under_one_key_and_keeps_the_first) {
  FactStore store(kA, {kA, kB});
  store.add(fact(kB, 3, 1.0));
  const std::uint64_t before = store.hash();
  EXPECT_EQ(store.add(fact(kB, 3, 2.0)), FactStore::Added::kConflict);
  EXPECT_EQ(store.hash(), before);
  const FindingList findings = store.take_findings();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "fleet.conflict");
  EXPECT_NE(findings[0].text.find("vehicle 2, epoch 0, number 3"), std::string::npos);
}

TEST(FactStore, inventory_lists_the_end_and_the_gaps_of_each_stream) {
  FactStore store(kA, {kA, kB});
  for (const std::uint32_t seq : {0U, 1U, 4U, 7U, 8U}) store.add(fact(kB, seq));
  store.add(fact(kB, 2, 0.0, 5));
  const Inventory inventory = store.inventory(9, 100);
  EXPECT_EQ(inventory.number, 9U);
  ASSERT_EQ(inventory.streams.size(), 2U);
  EXPECT_EQ(inventory.streams[0], (StreamInventory{{kB, 0}, 9, {{2, 3}, {5, 6}}}));
  EXPECT_EQ(inventory.streams[1], (StreamInventory{{kB, 5}, 3, {{0, 1}}}));
}

TEST(FactStore, the_order_of_arrival_changes_nothing) {
  std::vector<FactPtr> facts;
  for (std::uint32_t seq = 0; seq < 40; ++seq) {
    facts.push_back(fact(kA, seq, seq));
    facts.push_back(fact(kB, seq, -1.0 * seq));
  }
  FactStore in_order(kA, {kA, kB});
  for (const FactPtr& f : facts) in_order.add(f);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    FactStore store(kB, {kB, kA});
    std::vector<FactPtr> shuffled = facts;
    for (std::size_t k = shuffled.size(); k > 1; --k) {
      std::swap(shuffled[k - 1], shuffled[rng.below(k)]);
    }
    for (const FactPtr& f : shuffled) {
      store.add(f);
      if (rng.below(3) == 0) store.add(f);
    }
    EXPECT_EQ(store.hash(), in_order.hash());
    EXPECT_EQ(store.inventory(0, 0), in_order.inventory(0, 0));
  }
}

TEST(FactStore, stores_an_own_fact_quantised_as_it_is_sent) {
  FactStore store(kA, {kA, kB});
  Rng rng(1);
  const Fact own{{kA, 0, 0}, Time::from_s(1.0), random_increment(rng)};
  const auto kept = store.add_own(own);
  ASSERT_TRUE(kept);
  EXPECT_EQ(content_hash(**kept), content_hash(*quantised(own)));
  EXPECT_NE(content_hash(**kept), content_hash(own)) << "nothing was rounded";
  EXPECT_FALSE(store.add_own(own)) << "a number was used twice";
  EXPECT_FALSE(store.add_own(Fact{{kB, 0, 0}, {}, Increment{}})) << "another's fact as own";
}

TEST(FactStore, refuses_and_counts_unknown_vehicles_and_too_many_gaps_or_streams) {
  FactStore store(kA, {kA, kB}, StoreLimits{2, 3, 100});
  EXPECT_EQ(store.add(fact(VehicleId{9}, 0)), FactStore::Added::kRefused);
  for (std::uint32_t k = 1; k <= 3; ++k) {
    EXPECT_EQ(store.add(fact(kB, 2 * k)), FactStore::Added::kNew);
  }
  EXPECT_EQ(store.add(fact(kB, 8)), FactStore::Added::kRefused) << "a fourth gap";
  EXPECT_EQ(store.add(fact(kB, 7)), FactStore::Added::kNew) << "follows on the last one";
  EXPECT_EQ(store.add(fact(kB, 5)), FactStore::Added::kNew) << "fills a gap";
  EXPECT_EQ(store.add(fact(kB, 9)), FactStore::Added::kNew);
  EXPECT_EQ(store.add(fact(kA, 0, 0.0, 1)), FactStore::Added::kNew);
  EXPECT_EQ(store.add(fact(kA, 0, 0.0, 2)), FactStore::Added::kRefused) << "a third stream";
  EXPECT_EQ(store.add(fact(kB, std::numeric_limits<std::uint32_t>::max())),
            FactStore::Added::kRefused);
  EXPECT_EQ(store.refused(), 4U);
}

TEST(Reported, quantising_is_idempotent_for_every_kind_of_fact) {
  Rng rng(5);
  for (int k = 0; k < 20 * kBodies; ++k) {
    const Fact fact{{kA, 2, 7}, Time::from_s(3.0), random_body(rng, k % kBodies, kA)};
    const auto once = quantised(fact);
    ASSERT_TRUE(once) << k % kBodies;
    const auto twice = quantised(*once);
    ASSERT_TRUE(twice);
    EXPECT_EQ(content_hash(*once), content_hash(*twice)) << "kind " << k % kBodies;
  }
}

TEST(Reported, refuses_nan_infinite_or_inconsistent_values) {
  Rng rng(6);
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  Increment step = random_increment(rng);
  step.covariance(2, 3) = kNan;
  EXPECT_FALSE(quantised({{kA, 0, 0}, {}, step}));
  step = random_increment(rng);
  step.T_odom_body.R *= 1.1;
  EXPECT_FALSE(quantised({{kA, 0, 0}, {}, step})) << "no rotation";
  RangeBlock block = random_ranges(rng, kA, 1, 3);
  block.ranges[1].range_m = -1.0;
  EXPECT_FALSE(quantised({{kA, 0, 0}, {}, block}));
  KeyframePoints points = random_points(rng, 10, false);
  points.T_body_lidar.p.x() = kNan;
  const auto refused = quantised({{kA, 0, 8}, {}, points});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("number 8"), std::string::npos);
}

TEST(Reported, refuses_inertial_steps_with_invalid_duration_or_bias_random_walk) {
  Rng rng(7);
  const Increment good = random_increment(rng);
  ASSERT_TRUE(quantised({{kA, 0, 0}, {}, good}));
  for (const double bad : {0.0, -1.0, 1e9}) {
    Increment step = good;
    step.inertial->duration_s = bad;
    EXPECT_FALSE(quantised({{kA, 0, 0}, {}, step})) << bad;
  }
  for (const double bad : {0.0, -1e-5, 1e-60}) {
    Increment step = good;
    step.inertial->gyro_walk_radps_rts = bad;
    EXPECT_FALSE(quantised({{kA, 0, 0}, {}, step})) << bad;
    step = good;
    step.inertial->accel_walk_mps2_rts = bad;
    EXPECT_FALSE(quantised({{kA, 0, 0}, {}, step})) << bad;
  }
}

// Such a step caused an internal error in every solver that received it.
TEST(Reported, drops_an_inertial_step_with_an_indefinite_covariance) {
  Rng rng(8);
  Increment step = random_increment(rng);
  step.inertial->covariance.setIdentity();
  const auto hangs_together = [&](int i, int j, double correlation) {
    step.inertial->covariance(i, j) = step.inertial->covariance(j, i) = correlation;
  };
  hangs_together(0, 1, 1.0);
  const auto singular = quantised({{kA, 0, 0}, {}, step});
  ASSERT_TRUE(singular);
  EXPECT_TRUE(std::get<Increment>(singular->body).inertial) << "two that are one are possible";
  // a = b and b = c, but a = -c.
  hangs_together(1, 2, 1.0);
  hangs_together(0, 2, -1.0);
  const auto impossible = quantised({{kA, 0, 0}, {}, step});
  ASSERT_TRUE(impossible);
  EXPECT_FALSE(std::get<Increment>(impossible->body).inertial);
  const auto again = quantised(*impossible);
  ASSERT_TRUE(again);
  EXPECT_EQ(content_hash(*again), content_hash(*impossible));
}

}  // namespace
}  // namespace rali::fleet
