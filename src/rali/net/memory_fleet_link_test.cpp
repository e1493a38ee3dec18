#include "rali/net/memory_fleet_link.hpp"

#include <string_view>
#include <thread>

#include <gtest/gtest.h>

namespace rali::net {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr VehicleId kV1{1}, kV2{2}, kV3{3};

class MemoryFleetLinks : public ::testing::Test {
 protected:
  Time now_ = Time::from_ns(5);
  MemoryFleet fleet_{{kV1, kV2, kV3}, [this] { return now_; }, 4};
  std::unique_ptr<FleetLink> v1_ = fleet_.link(kV1), v2_ = fleet_.link(kV2), v3_ = fleet_.link(kV3);
};

TEST_F(MemoryFleetLinks, a_message_reaches_only_its_receiver) {
  EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, Bytes{7, 8}));
  EXPECT_TRUE(v3_->take().empty());
  const auto arrived = v2_->take();
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].from, kV1);
  EXPECT_EQ(arrived[0].t, now_);
  EXPECT_EQ(arrived[0].bytes, (Bytes{7, 8}));
  EXPECT_TRUE(v2_->take().empty());
}

TEST_F(MemoryFleetLinks, a_broadcast_reaches_all_other_vehicles) {
  EXPECT_TRUE(v1_->send(std::nullopt, Urgency::kRole, Bytes{1}));
  EXPECT_EQ(v2_->take().size(), 1U);
  EXPECT_EQ(v3_->take().size(), 1U);
  EXPECT_TRUE(v1_->take().empty());
}

TEST_F(MemoryFleetLinks, a_full_queue_refuses_facts_and_drops_the_oldest_role) {
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, Bytes(1)));
  EXPECT_FALSE(v1_->send(kV2, Urgency::kBulk, Bytes(1)));
  EXPECT_TRUE(v3_->send(kV2, Urgency::kBulk, Bytes(1))) << "another sender has room of its own";
  for (std::uint8_t i = 0; i < 6; ++i) EXPECT_TRUE(v1_->send(kV2, Urgency::kRole, Bytes{i}));
  const auto arrived = v2_->take();
  ASSERT_EQ(arrived.size(), 4U + 1U + 4U);
  EXPECT_EQ(arrived.back().bytes, Bytes{5});
  EXPECT_EQ(v1_->counts()[0].refused, 1U);
  EXPECT_EQ(v2_->counts()[0].overflowed, 2U);
}

TEST_F(MemoryFleetLinks, a_cut_blocks_one_direction_only) {
  fleet_.cut(kV1, kV2, true);
  EXPECT_FALSE(v1_->send(kV2, Urgency::kBulk, Bytes{1})) << "nobody is there";
  EXPECT_TRUE(v1_->send(kV2, Urgency::kRole, Bytes{1})) << "sent into nothing";
  EXPECT_TRUE(v2_->take().empty());
  EXPECT_TRUE(v2_->send(kV1, Urgency::kBulk, Bytes{1}));
  EXPECT_EQ(v1_->take().size(), 1U);
  EXPECT_FALSE(v1_->counts()[0].matched);
  EXPECT_TRUE(v2_->counts()[0].matched);
  fleet_.cut(kV1, kV2, false);
  EXPECT_TRUE(v1_->send(kV2, Urgency::kBulk, Bytes{1}));
}

TEST_F(MemoryFleetLinks, a_closed_link_receives_nothing_and_does_not_block_others) {
  v3_.reset();
  EXPECT_FALSE(v1_->send(kV3, Urgency::kBulk, Bytes{1}));
  EXPECT_TRUE(v1_->send(std::nullopt, Urgency::kBulk, Bytes{1}));
  EXPECT_EQ(v2_->take().size(), 1U);
  EXPECT_FALSE(v1_->send(VehicleId{9}, Urgency::kRole, Bytes{1})) << "of no fleet";
}

TEST_F(MemoryFleetLinks, waiting_ends_when_another_thread_sends_a_message) {
  EXPECT_FALSE(v2_->wait(Duration::from_s(0.01)));
  std::thread sender([this] { EXPECT_TRUE(v1_->send(kV2, Urgency::kRole, Bytes{1})); });
  EXPECT_TRUE(v2_->wait(Duration::from_s(10.0)));
  sender.join();
  EXPECT_EQ(v2_->take().size(), 1U);
}

}  // namespace
}  // namespace rali::net
