#include "rali/host/fleet_side.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/host/fleet_state.hpp"
#include "rali/net/memory_fleet_link.hpp"

namespace rali::host {
namespace {

using geometry::SE3;
using geometry::Vec3;

const std::vector<std::string> kNames = {"v1", "v2", "v3"};

FleetSideSetup setup_of(std::size_t index, const std::vector<SE3>& starts) {
  FleetSideSetup setup;
  setup.agent.self = VehicleId{static_cast<std::uint16_t>(index)};
  setup.agent.names = kNames;
  for (std::size_t v = 1; v < starts.size(); ++v) {
    fleet::GivenStart start;
    start.relative_to = VehicleId{0};
    start.vehicle = VehicleId{static_cast<std::uint16_t>(v)};
    start.T_relative_vehicle = starts[0].inverse() * starts[v];
    setup.agent.known.starts.push_back(start);
  }
  return setup;
}

/// A vehicle that knows exactly where it is in the hall, in place of sensors and odometry.
class ExactVehicle {
 public:
  ExactVehicle(std::size_t index, const std::vector<SE3>& starts, double speed_mps,
               net::MemoryFleet& fleet, HostTime now)
      : id_{static_cast<std::uint16_t>(index)},
        T_world_start_(starts[index]),
        speed_mps_(speed_mps),
        side(setup_of(index, starts), now),
        link_(fleet.link(id_)) {
    FleetSideOutputs out;
    side.take(ClockNews{}, now, out);
    make_fact(now.wall, fleet::EpochStart{kNames[index], {Vec3::Zero()}}, now);
  }

  void order(const view::OperatorRequest& request, HostTime now) { side.take(request, now, out_); }

  /// A tenth of a second goes by.
  void step(HostTime now, double t_s) {
    measure(now, t_s);
    for (const net::Arrived& arrived : link_->take()) {
      side.receive(arrived.from, std::as_bytes(std::span(arrived.bytes)), now, out_);
    }
    side.tick(now, out_);
    while (!out_.agent.empty()) obey(std::exchange(out_.agent, {}), now);
    for (RosOut& message : out_.publish) published.push_back(std::move(message));
    for (const ToSensors& news : out_.sensors) {
      peers_heard += std::holds_alternative<fleet::PeerStatus>(news) ? 1 : 0;
    }
    out_ = {};
  }

 private:
  VehicleId id_;
  SE3 T_world_start_;
  double speed_mps_;

 public:
  FleetSide side;
  std::vector<RosOut> published;
  std::size_t peers_heard = 0;

 private:
  /// Jobs end at once; what follows from them is obeyed next.
  void obey(const AgentOutputs& made, HostTime now) {
    for (const AgentOutput& output : made) {
      if (const auto* job = std::get_if<fleet::RunJob>(&output)) {
        SerialExecutor executor;
        job->job->run(executor, false);
        side.take(fleet::JobDone{job->number, job->job}, now, out_);
      } else if (const auto* send = std::get_if<SendBytes>(&output)) {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(send->bytes.data());
        static_cast<void>(link_->send(send->to, send->urgency, {bytes, send->bytes.size()}));
      }
    }
  }

  void give(vehicle::Output output, HostTime now) {
    side.take(VehicleNews{std::move(output)}, now, out_);
  }

  void make_fact(Time t, fleet::FactBody body, HostTime now) {
    const fleet::Fact fact{{id_, 0, facts_++}, t, std::move(body), {}};
    give(vehicle::FactMade{std::make_shared<const fleet::Fact>(fact)}, now);
  }

  void measure(HostTime now, double t_s) {
    const double driven_m = speed_mps_ * std::clamp(t_s - 5.0, 0.0, 16.0);
    const bool at_rest = driven_m == driven_last_m_;
    driven_last_m_ = driven_m;
    vehicle::PoseEstimate pose;
    pose.vehicle = id_;
    pose.t = now.wall;
    pose.T_local_body.p.x() = driven_m;
    pose.T_odom_body = pose.T_local_body;
    pose.covariance = geometry::Mat6::Identity() * 1e-6;
    pose.at_rest = at_rest;
    give(vehicle::PeerStatus{id_, now.wall, at_rest, fleet::PeerPose{pose.T_local_body}}, now);
    give(pose, now);
    const bool keyframe = facts_ < 2 || driven_m - keyframe_m_ >= 1.0;
    if (!keyframe && t_s - node_s_ < 1.0) return;
    node_s_ = t_s;
    fleet::Increment step;
    step.node = nodes_++;
    if (keyframe) step.keyframe = keyframes_++;
    step.begins = step.node == 0;
    step.at_rest = at_rest;
    step.levelled = true;
    step.T_odom_body = pose.T_odom_body;
    step.covariance = pose.covariance;
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    make_fact(now.wall, step, now);
    if (!keyframe) return;
    keyframe_m_ = driven_m;
    make_fact(now.wall, points_at(T_world_start_ * pose.T_odom_body, *step.keyframe), now);
  }

  static fleet::KeyframePoints points_at(const SE3& T_world_body, std::uint32_t number) {
    fleet::KeyframePoints points;
    points.keyframe = number;
    for (int k = 0; k < 3200; ++k) {
      const double up = (2.0 * (k % 16) - 15.0) * std::numbers::pi / 180.0;
      const double turn = 2.0 * std::numbers::pi * (k / 16) / 200.0 + 0.003;
      const Vec3 d(std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up));
      const Vec3 p = drive::test::HallRecording::distance(T_world_body.p, T_world_body.R * d) * d;
      points.x_m.push_back(static_cast<float>(p.x()));
      points.y_m.push_back(static_cast<float>(p.y()));
      points.z_m.push_back(static_cast<float>(p.z()));
    }
    return points;
  }

  std::unique_ptr<net::FleetLink> link_;
  FleetSideOutputs out_;
  std::uint32_t facts_ = 0, nodes_ = 0, keyframes_ = 0;
  double driven_last_m_ = 0.0, keyframe_m_ = 0.0, node_s_ = -1.0;
};

/// Three vehicles in the hall: the first stands, the others drive eight metres.
class FleetSideTest : public testing::Test {
 protected:
  FleetSideTest() {
    for (std::size_t v = 0; v < 3; ++v) {
      vehicles_.push_back(std::make_unique<ExactVehicle>(v, starts_, v == 0 ? 0.0 : 0.5, fleet_,
                                                         HostTime{now_, now_}));
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

TEST_F(FleetSideTest, three_vehicles_share_one_map_over_bytes) {
  run(40.0);
  EXPECT_EQ(agent(0).node().mode(), fleet::Mode::kAnchor);
  const MapPicture& picture = vehicles_[0]->side.picture();
  for (std::size_t v = 0; v < 3; ++v) {
    ASSERT_TRUE(agent(v).node().T_map_odom()) << kNames[v];
    const auto T = picture.T_map_local(VehicleId{static_cast<std::uint16_t>(v)});
    ASSERT_TRUE(T) << kNames[v];
    const SE3 expected = starts_[0].inverse() * starts_[v];
    EXPECT_LT((T->p - expected.p).norm(), 0.05) << kNames[v];
    EXPECT_GT(vehicles_[v]->peers_heard, 100U);
    EXPECT_EQ(agent(v).tally().unreadable, 0U);
    EXPECT_EQ(agent(v).heard().size(), 3U);
  }
  EXPECT_EQ(picture.paths().size(), 3U);
}

TEST_F(FleetSideTest, what_a_vehicle_is_to_publish_is_published) {
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

TEST_F(FleetSideTest, a_vehicle_that_is_cut_off_is_seen_as_silent_and_harms_nobody) {
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
  EXPECT_NE(agent(2).node().mode(), fleet::Mode::kAnchor);  // no majority hears it
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

TEST_F(FleetSideTest, an_order_that_nobody_knows_is_a_finding) {
  run(5.0);
  FleetSideOutputs out;
  vehicles_[0]->side.take(view::OperatorRequest{"assume-lost", "v9"}, {now_, now_}, out);
  ASSERT_FALSE(vehicles_[0]->side.findings().empty());
  EXPECT_EQ(vehicles_[0]->side.findings().back().finding.text,
            "unknown order of the operator: assume-lost v9");
}

TEST_F(FleetSideTest, bytes_that_are_no_message_are_counted_and_dropped) {
  run(2.0);
  FleetSideOutputs out;
  const std::vector<std::byte> noise(100, std::byte{0x5a});
  vehicles_[0]->side.receive(VehicleId{1}, noise, {now_, now_}, out);
  EXPECT_EQ(agent(0).tally().unreadable, 1U);
}

TEST_F(FleetSideTest, the_state_of_the_page_is_json_without_anything_unknown) {
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
