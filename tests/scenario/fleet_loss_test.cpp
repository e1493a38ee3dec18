// A bad radio only delays the map of a fleet.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "fleet_estimate_text.hpp"
#include "rali/base/rng.hpp"
#include "rali/drive/link/post.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/fleet/facts/exchange.hpp"

namespace rali {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr int kVehicles = 3;
constexpr double kData_s = 20.0;  // of driving
constexpr double kSpeed_mps = 0.8;

VehicleId id_of(int v) { return VehicleId{static_cast<std::uint16_t>(v)}; }

/// Each vehicle drives a circle with its own radius and centre, heading along the path.
SE3 truth(int v, double t_s) {
  const double radius_m = 4.0 + v;
  const double a = kSpeed_mps * t_s / radius_m + 0.7 * v;
  SE3 T;
  T.p = {6.0 * v + radius_m * std::cos(a), 3.0 * v + radius_m * std::sin(a), 0.0};
  T.R = geometry::rotation_from_rpy(0.0, 0.0, a + 0.5 * std::numbers::pi);
  return T;
}

/// Odom starts at the first pose; its scale error is half a per cent.
SE3 in_odom(int v, double t_s) {
  SE3 T = truth(v, 0.0).inverse() * truth(v, t_s);
  T.p *= 1.0 + 0.005 * (v - 1);
  return T;
}

/// Corners and pillars of a hall, as points on vertical lines and walls.
std::vector<Vec3> hall() {
  std::vector<Vec3> points;
  for (double z = 0.0; z < 2.5; z += 0.5) {
    for (double s = -8.0; s < 24.0; s += 0.5) {
      points.push_back({s, -9.0, z});
      points.push_back({s, 17.0, z});
      points.push_back({-8.0, s - 1.0 > 17.0 ? 17.0 : s - 1.0, z});
      points.push_back({24.0, s - 1.0 > 17.0 ? 17.0 : s - 1.0, z});
    }
  }
  return points;
}

fleet::KeyframePoints seen_from(std::uint32_t keyframe, const SE3& T_world_body,
                                const std::vector<Vec3>& world) {
  fleet::KeyframePoints points;
  fleet::PointArrays arrays;
  points.keyframe = keyframe;
  for (const Vec3& p : world) {
    const Vec3 q = T_world_body.inverse() * p;
    if (q.norm() > 12.0) continue;
    arrays.push_back(static_cast<float>(q.x()), static_cast<float>(q.y()),
                     static_cast<float>(q.z()));
  }
  points.points = fleet::PackedPoints(arrays);
  return points;
}

fleet::Increment increment(int v, std::uint32_t node, double t_s) {
  fleet::Increment step;
  step.node = node;
  step.keyframe = node;
  step.begins = node == 0;
  step.levelled = true;
  step.T_odom_body = in_odom(v, t_s);
  step.covariance.diagonal().setConstant(1e-6 * (1.0 + node));
  step.lidar_information.diagonal().setConstant(1e6);
  return step;
}

/// A second of ranges to the vehicles with the next and the previous number.
fleet::RangeBlock ranges(int v, double from_s, Rng& rng) {
  fleet::RangeBlock block;
  for (int k = 0; k < 5; ++k) {
    const double t_s = from_s + 0.2 * k + 0.05 * v;
    for (int other = 0; other < kVehicles; ++other) {
      if (other <= v) continue;
      fleet::RangeEntry entry;
      entry.t = Time::from_s(t_s);
      entry.from = id_of(v);
      entry.to = id_of(other);
      entry.range_m = (truth(v, t_s).p - truth(other, t_s).p).norm() + 0.04 * rng.normal();
      entry.T_odom_body = in_odom(v, t_s);
      block.ranges.push_back(entry);
    }
  }
  return block;
}

/// All facts that one vehicle sends during the mission.
std::vector<fleet::Fact> facts_of(int v, const std::vector<Vec3>& world) {
  Rng rng(static_cast<std::uint64_t>(v), "facts");
  std::vector<fleet::Fact> facts;
  const auto report = [&](double t_s, fleet::FactBody body) {
    const auto seq = static_cast<std::uint32_t>(facts.size());
    facts.push_back({{id_of(v), 0, seq}, Time::from_s(t_s), std::move(body)});
  };
  report(0.0, fleet::EpochStart{"v" + std::to_string(v + 1), {Vec3::Zero()}});
  for (std::uint32_t node = 0; node <= static_cast<std::uint32_t>(kData_s); ++node) {
    const double t_s = node;
    report(t_s, increment(v, node, t_s));
    report(t_s, seen_from(node, truth(v, t_s), world));
    if (v + 1 < kVehicles && t_s < kData_s) report(t_s + 0.9, ranges(v, t_s, rng));
  }
  return facts;
}

fleet::FleetKnowledge knowledge() {
  fleet::FleetKnowledge known;
  for (int v = 1; v < kVehicles; ++v) {
    fleet::GivenStart start;
    start.relative_to = id_of(0);
    start.vehicle = id_of(v);
    start.T_relative_vehicle = truth(0, 0.0).inverse() * truth(v, 0.0);
    start.T_relative_vehicle.p.x() += 0.1;
    known.starts.push_back(start);
  }
  return known;
}

std::string estimate_of(const std::vector<fleet::FactPtr>& facts) {
  fleet::Centre centre(fleet::FleetSettings{}, knowledge());
  for (const fleet::FactPtr& fact : facts) centre.add(fact);
  SerialExecutor executor;
  return text_of(centre.estimate(executor));
}

struct Node {
  Node(int v, const std::vector<VehicleId>& fleet)
      : store(id_of(v), fleet), exchange(id_of(v), fleet, {}) {}

  fleet::FactStore store;
  fleet::Exchange exchange;
  std::vector<fleet::Fact> to_make;
  std::size_t made = 0;
  std::vector<fleet::FactPtr> arrived;  ///< own and received, in order of arrival
};

/// Vehicles that send each other their facts while they create them.
class RadioFleet {
 public:
  explicit RadioFleet(const drive::LinkSettings& link, std::uint64_t seed)
      : ids_(ids()), radio(ids_, link, seed) {
    const std::vector<Vec3> world = hall();
    for (int v = 0; v < kVehicles; ++v) {
      nodes.emplace_back(v, ids_);
      nodes.back().to_make = facts_of(v, world);
    }
  }

  /// Runs until every vehicle has all facts, at most until `max_s`.
  void run(double max_s) {
    for (double t_s = 0.0; t_s < max_s && !done(); t_s += 0.1) step(Time::from_s(t_s));
  }

 private:
  static std::vector<VehicleId> ids() {
    std::vector<VehicleId> all;
    for (int v = 0; v < kVehicles; ++v) all.push_back(id_of(v));
    return all;
  }

  [[nodiscard]] bool done() const {
    for (const Node& node : nodes) {
      if (node.made < node.to_make.size() || node.store.hash() != nodes[0].store.hash()) {
        return false;
      }
    }
    return true;
  }

  void step(Time now) {
    for (const drive::Received& received : drive::collect(radio, now).received) {
      Node& node = nodes[received.to.value];
      node.exchange.receive(received.envelope, node.store, now);
    }
    for (Node& node : nodes) {
      for (; node.made < node.to_make.size() && node.to_make[node.made].t <= now; ++node.made) {
        EXPECT_TRUE(node.store.add_own(node.to_make[node.made]));
      }
      for (fleet::FactPtr& fact : node.store.take_new()) node.arrived.push_back(std::move(fact));
      for (const fleet::Envelope& envelope : node.exchange.step(node.store, now)) {
        EXPECT_TRUE(drive::post(radio, now, envelope));
      }
    }
  }

  std::vector<VehicleId> ids_;

 public:
  drive::Loopback radio;
  std::vector<Node> nodes;
};

/// All facts in order, as if transmitted at once.
std::vector<fleet::FactPtr> undisturbed() {
  const std::vector<Vec3> world = hall();
  std::vector<fleet::FactPtr> all;
  std::vector<VehicleId> ids;
  for (int v = 0; v < kVehicles; ++v) ids.push_back(id_of(v));
  for (int v = 0; v < kVehicles; ++v) {
    fleet::FactStore store(id_of(v), ids);
    for (const fleet::Fact& fact : facts_of(v, world)) {
      const auto reported = store.add_own(fact);
      EXPECT_TRUE(reported);
      if (reported) all.push_back(*reported);
    }
  }
  return all;
}

TEST(FleetLoss, every_vehicle_computes_the_same_map_despite_radio_faults) {
  const std::vector<fleet::FactPtr> facts = undisturbed();
  const std::string expected = estimate_of(facts);
  ASSERT_NE(expected.find("group 0 1 2\n"), std::string::npos) << expected.substr(0, 500);
  drive::LinkSettings bad;
  bad.loss = 0.2;
  bad.duplication = 0.2;
  bad.delay_s = 0.05;
  bad.jitter_s = 1.5;
  bad.reordering = 0.2;
  RadioFleet fleet(bad, 5);
  fleet.radio.cut_off(id_of(1), Time::from_s(5.0), Time::from_s(25.0));
  fleet.run(600.0);
  for (int v = 0; v < kVehicles; ++v) {
    const Node& node = fleet.nodes[static_cast<std::size_t>(v)];
    EXPECT_EQ(node.arrived.size(), facts.size()) << "a fact was lost on its way to vehicle " << v;
    // In order of arrival, with points before their increments and temporary gaps.
    EXPECT_EQ(estimate_of(node.arrived), expected) << "vehicle " << v;
  }
}

TEST(FleetLoss, the_estimate_does_not_depend_on_the_order_of_facts) {
  std::vector<fleet::FactPtr> facts = undisturbed();
  const std::string expected = estimate_of(facts);
  std::reverse(facts.begin(), facts.end());
  EXPECT_EQ(estimate_of(facts), expected);
  Rng rng(3, "shuffle");
  for (std::size_t i = facts.size(); i > 1; --i) std::swap(facts[i - 1], facts[rng.below(i)]);
  EXPECT_EQ(estimate_of(facts), expected);
}

TEST(FleetLoss, half_of_the_facts_give_a_map_of_half_the_keyframes) {
  const std::vector<fleet::FactPtr> facts = undisturbed();
  std::vector<fleet::FactPtr> half;
  for (const fleet::FactPtr& fact : facts) {
    if (fact->t <= Time::from_s(0.5 * kData_s)) half.push_back(fact);
  }
  fleet::Centre centre(fleet::FleetSettings{}, knowledge());
  for (const fleet::FactPtr& fact : half) centre.add(fact);
  SerialExecutor executor;
  const fleet::FleetEstimate estimate = centre.estimate(executor);
  EXPECT_EQ(estimate.keyframes.size(), kVehicles * (static_cast<std::size_t>(kData_s) / 2 + 1));
}

}  // namespace
}  // namespace rali
