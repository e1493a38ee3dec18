#include "rali/host/fleet_side.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/host/exact_vehicle_for_test.hpp"
#include "rali/host/fleet_state.hpp"
#include "rali/net/memory_fleet_link.hpp"

namespace rali::host {
namespace {

using geometry::SE3;
using geometry::Vec3;

const std::vector<std::string> kNames = {"v1", "v2", "v3"};

/// Three vehicles in the hall: the first stands still, the others drive eight metres.
class FleetSideTest : public testing::Test {
 protected:
  FleetSideTest() {
    for (std::size_t v = 0; v < 3; ++v) {
      const VehicleId id{static_cast<std::uint16_t>(v)};
      vehicles_.push_back(std::make_unique<ExactVehicle>(v, kNames, starts_, v == 0 ? 0.0 : 0.5,
                                                         fleet_.link(id), HostTime{now_, now_}));
    }
  }

  void run(double duration_s) {
    for (int k = 0; k < static_cast<int>(duration_s * 10.0); ++k) {
      t_s_ += 0.1;
      now_ = kBegin + Duration::from_s(t_s_);
      for (const auto& vehicle : vehicles_) vehicle->step({now_, now_}, t_s_);
    }
  }

  const Agent& agent(std::size_t v) { return *vehicles_[v]->side.agent(); }

  static constexpr Time kBegin = Time::from_ns(1'700'000'000'000'000'000);
  double t_s_ = 0.0;
  Time now_ = kBegin;
  std::vector<SE3> starts_ = {{geometry::Mat3::Identity(), Vec3(5.0, 6.0, 0.8)},
                              {geometry::Mat3::Identity(), Vec3(5.0, 4.0, 0.8)},
                              {geometry::Mat3::Identity(), Vec3(5.0, 7.5, 0.8)}};
  net::MemoryFleet fleet_{
      {VehicleId{0}, VehicleId{1}, VehicleId{2}}, [this] { return now_; }, 4096};
  std::vector<std::unique_ptr<ExactVehicle>> vehicles_;
};

TEST_F(FleetSideTest, three_vehicles_share_one_map_over_encoded_messages) {
  run(40.0);
  EXPECT_EQ(agent(0).node().mode(), fleet::Mode::kAnchor);
  const auto& frames = vehicles_[0]->side.picture().T_map_local;
  for (std::size_t v = 0; v < 3; ++v) {
    ASSERT_TRUE(agent(v).node().T_map_odom()) << kNames[v];
    const auto T = frames.find(VehicleId{static_cast<std::uint16_t>(v)});
    ASSERT_NE(T, frames.end()) << kNames[v];
    const SE3 expected = starts_[0].inverse() * starts_[v];
    EXPECT_LT((T->second.p - expected.p).norm(), 0.05) << kNames[v];
    EXPECT_GT(vehicles_[v]->peers_received, 100U);
    EXPECT_EQ(agent(v).tally().unreadable, 0U);
    EXPECT_EQ(agent(v).received().size(), 3U);
  }
  ASSERT_FALSE(vehicles_[0]->paths.empty());
  EXPECT_EQ(nlohmann::json::parse(vehicles_[0]->paths.back())["paths"].size(), 3U);
}

TEST_F(FleetSideTest, publishes_role_map_and_frontiers) {
  run(40.0);
  std::array<std::size_t, kRosTopics> counts{};
  for (const RosOut& out : vehicles_[0]->published) {
    ++counts[static_cast<std::size_t>(out.topic)];
    EXPECT_FALSE(out.cdr.empty());
  }
  const auto of = [&](RosTopicId id) { return counts[static_cast<std::size_t>(id)]; };
  EXPECT_GE(of(RosTopicId::kRole), 38U);
  EXPECT_GE(of(RosTopicId::kMap), 5U);
  EXPECT_GE(of(RosTopicId::kMapDelta), 5U);
  EXPECT_GE(of(RosTopicId::kMapCloud), 1U);
  EXPECT_GE(of(RosTopicId::kFrontiers), 1U);
}

// Drawing takes longer for a larger map; the agent's steps must not.
TEST_F(FleetSideTest, draws_the_map_in_a_background_job_and_repeats_a_lost_job) {
  run(20.0);
  FleetSide& side = vehicles_[0]->side;
  const auto tick = [&](FleetSideOutputs& out) {
    t_s_ += 2.0;
    now_ = kBegin + Duration::from_s(t_s_);
    side.tick({now_, now_}, out);
  };
  const auto points_of = [](const FleetSideOutputs& out) {
    return std::count_if(out.publish.begin(), out.publish.end(), [](const RosOut& message) {
      return message.topic == RosTopicId::kMapDelta || message.topic == RosTopicId::kMapCloud;
    });
  };
  FleetSideOutputs first, second;
  tick(first);
  ASSERT_NE(first.picture, nullptr);
  tick(second);
  EXPECT_EQ(second.picture, nullptr) << "one at a time";
  EXPECT_EQ(points_of(first) + points_of(second), 0);
  side.take_picture(nullptr, {now_, now_}, second);  // lost
  EXPECT_GT(side.picture().keyframes, 0U) << "what was shown stays";
  FleetSideOutputs third;
  tick(third);
  ASSERT_NE(third.picture, nullptr);
  SerialExecutor executor;
  third.picture->run(executor, false);
  side.take_picture(third.picture.get(), {now_, now_}, third);
  EXPECT_GE(points_of(third), 1) << "all facts are read and drawn anew";
}

TEST_F(FleetSideTest, reports_a_disconnected_vehicle_without_affecting_the_anchor) {
  run(20.0);
  for (const VehicleId other : {VehicleId{0}, VehicleId{1}}) {
    fleet_.cut(VehicleId{2}, other, true);
    fleet_.cut(other, VehicleId{2}, true);
  }
  run(15.0);
  HostFacts host;
  host.has_link = true;
  host.links = {{VehicleId{1}}, {VehicleId{2}}};
  const auto lines = diagnose(vehicles_[0]->side, host, {now_, now_});
  const auto line = std::find_if(lines.begin(), lines.end(),
                                 [](const DiagnosticLine& l) { return l.name == "fleet/link_v3"; });
  ASSERT_NE(line, lines.end());
  EXPECT_EQ(line->level, DiagnosticLevel::kWarn);
  EXPECT_EQ(agent(0).node().mode(), fleet::Mode::kAnchor);
  EXPECT_NE(agent(2).node().mode(), fleet::Mode::kAnchor);  // it does not reach a majority
}

TEST_F(FleetSideTest, the_operator_ends_a_round_of_the_anchor) {
  run(20.0);
  ASSERT_EQ(agent(0).node().mode(), fleet::Mode::kAnchor);
  const auto term = agent(0).node().term();
  vehicles_[0]->order({"end-round", ""}, {now_, now_});
  EXPECT_EQ(agent(0).node().mode(), fleet::Mode::kSealed);
  run(20.0);
  EXPECT_GT(agent(0).node().term(), term);
}

TEST_F(FleetSideTest, an_unknown_operator_order_is_a_finding) {
  run(5.0);
  FleetSideOutputs out;
  vehicles_[0]->side.take(view::OperatorRequest{"assume-lost", "v9"}, {now_, now_}, out);
  ASSERT_FALSE(vehicles_[0]->side.findings().empty());
  EXPECT_EQ(vehicles_[0]->side.findings().back().finding.text,
            "unknown order of the operator: assume-lost v9");
}

TEST_F(FleetSideTest, counts_and_drops_undecodable_bytes) {
  run(2.0);
  FleetSideOutputs out;
  const std::vector<std::byte> noise(100, std::byte{0x5a});
  vehicles_[0]->side.receive(VehicleId{1}, noise, {now_, now_}, out);
  EXPECT_EQ(agent(0).tally().unreadable, 1U);
}

TEST_F(FleetSideTest, state_json_contains_no_null_values) {
  run(40.0);
  HostFacts host;
  host.has_link = true;
  host.links = {{VehicleId{1}}, {VehicleId{2}}};
  const LiveState state = live_state(vehicles_[0]->side, host, {now_, now_});
  const auto json = nlohmann::json::parse(state_json(state));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["vehicle"], "v1");
  EXPECT_EQ(json["anchor"]["vehicle"], "v1");
  ASSERT_EQ(json["vehicles"].size(), 3U);
  EXPECT_NEAR(json["vehicles"][1]["position_m"][0].get<double>(), 8.0, 0.1);
  EXPECT_NEAR(json["vehicles"][1]["position_m"][1].get<double>(), -2.0, 0.1);
  EXPECT_EQ(state_json(state).find("null"), std::string::npos);
  std::string health;
  EXPECT_FALSE(health_json(state, health));  // no sensors in this test
  EXPECT_NE(metrics_text(state).find("rali_term{vehicle=\"v1\"} 1\n"), std::string::npos);
}

}  // namespace
}  // namespace rali::host
