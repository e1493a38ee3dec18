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

fleet::PeerStatus said(std::uint16_t vehicle, double t_s) {
  return {VehicleId{vehicle}, Time::from_s(t_s), true};
}

/// Who heard what, over 10 s in which all but the dead speak ten times a second.
std::vector<FleetNodes::HeardStatus> heard_in(double loss, std::optional<std::size_t> dead) {
  FleetNodes nodes(three(loss), Time::from_s(0));
  SerialExecutor executor;
  if (dead) nodes.kill(*dead);
  std::vector<FleetNodes::HeardStatus> all;
  for (int k = 1; k <= 100; ++k) {
    const double t_s = 0.1 * k;
    nodes.advance(Time::from_s(t_s));
    for (std::uint16_t v = 0; v < 3; ++v) nodes.say(v, said(v, t_s));
    static_cast<void>(nodes.decide(Time::from_s(t_s + 0.05), {}, executor));
    for (FleetNodes::HeardStatus& heard : nodes.take_heard()) all.push_back(std::move(heard));
  }
  return all;
}

// What vehicles said of themselves went around the radio: nothing that a radio loses was lost.
TEST(FleetNodes, what_vehicles_say_of_themselves_goes_over_the_radio_to_all_others) {
  const auto all = heard_in(0.0, std::nullopt);
  EXPECT_EQ(all.size(), 600U);
  for (const FleetNodes::HeardStatus& heard : all) EXPECT_NE(heard.to, heard.status.vehicle.value);
  const auto some = heard_in(0.2, std::nullopt);
  EXPECT_LT(some.size(), 540U);
  EXPECT_GT(some.size(), 420U);
}

TEST(FleetNodes, who_is_dead_neither_says_nor_hears_anything) {
  const auto all = heard_in(0.0, 1);
  EXPECT_EQ(all.size(), 200U);
  for (const FleetNodes::HeardStatus& heard : all) {
    EXPECT_NE(heard.to, 1U);
    EXPECT_NE(heard.status.vehicle.value, 1U);
  }
}

}  // namespace
}  // namespace rali::drive
