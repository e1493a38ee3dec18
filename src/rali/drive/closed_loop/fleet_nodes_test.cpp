#include "rali/drive/closed_loop/fleet_nodes.hpp"

#include <gtest/gtest.h>

#include "rali/base/executor.hpp"

namespace rali::drive {
namespace {

FleetNodesSetup three(double loss) {
  FleetNodesSetup setup;
  setup.names = {"v1", "v2", "v3"};
  setup.link.loss = loss;
  return setup;
}

fleet::PeerStatus reported(std::uint16_t vehicle, double t_s) {
  return {VehicleId{vehicle}, Time::from_s(t_s), true};
}

/// Received peer states over 10 s in which all vehicles but the dead one send ten times a second.
std::vector<FleetNodes::ReceivedStatus> received_in(double loss, std::optional<std::size_t> dead) {
  FleetNodes nodes(three(loss), Time::from_s(0));
  SerialExecutor executor;
  if (dead) nodes.kill(*dead);
  std::vector<FleetNodes::ReceivedStatus> all;
  for (int k = 1; k <= 100; ++k) {
    const double t_s = 0.1 * k;
    nodes.advance(Time::from_s(t_s));
    for (std::uint16_t v = 0; v < 3; ++v) nodes.report(v, reported(v, t_s));
    static_cast<void>(nodes.decide(Time::from_s(t_s + 0.05), {}, executor));
    for (FleetNodes::ReceivedStatus& received : nodes.take_received())
      all.push_back(std::move(received));
  }
  return all;
}

// Peer states once bypassed the radio: the losses of a radio did not affect them.
TEST(FleetNodes, broadcast_their_status_to_all_others_over_a_lossy_radio) {
  const auto all = received_in(0.0, std::nullopt);
  EXPECT_EQ(all.size(), 600U);
  for (const FleetNodes::ReceivedStatus& received : all)
    EXPECT_NE(received.to, received.status.vehicle.value);
  const auto some = received_in(0.2, std::nullopt);
  EXPECT_LT(some.size(), 540U);
  EXPECT_GT(some.size(), 420U);
}

TEST(FleetNodes, a_dead_vehicle_neither_sends_nor_receives) {
  const auto all = received_in(0.0, 1);
  EXPECT_EQ(all.size(), 200U);
  for (const FleetNodes::ReceivedStatus& received : all) {
    EXPECT_NE(received.to, 1U);
    EXPECT_NE(received.status.vehicle.value, 1U);
  }
}

}  // namespace
}  // namespace rali::drive
