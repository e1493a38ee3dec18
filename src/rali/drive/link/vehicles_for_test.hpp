#pragma once

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "rali/drive/link/post.hpp"
#include "rali/fleet/facts/exchange.hpp"

namespace rali::drive {

/// A fact of varying kind: epoch start, then in turn an increment, ranges, points.
inline fleet::Fact some_fact(VehicleId vehicle, std::uint32_t seq, Time t) {
  fleet::Fact fact{{vehicle, 0, seq}, t, fleet::EpochStart{"v", {}}};
  if (seq == 0) return fact;
  const double s = 0.1 * seq + vehicle.value;
  if (seq % 3 == 1) {
    fleet::Increment step;
    step.node = seq;
    step.T_odom_body.p = {s, std::sin(s), 0.0};
    step.inertial.emplace().duration_s = 0.3;
    fact.body = step;
  } else if (seq % 3 == 2) {
    fleet::RangeBlock block;
    for (int k = 0; k < 20; ++k) {
      fleet::RangeEntry entry;
      entry.t = t + Duration::from_s(0.02 * k);
      entry.from = vehicle;
      entry.to = VehicleId{static_cast<std::uint16_t>(vehicle.value + 1)};
      entry.range_m = 5.0 + 0.01 * k;
      entry.T_odom_body.p = {s + 0.02 * k, 0.0, 0.0};
      block.ranges.push_back(entry);
    }
    fact.body = block;
  } else {
    fleet::KeyframePoints points;
    fleet::PointArrays arrays;
    points.keyframe = seq;
    for (int k = 0; k < 100; ++k) {
      arrays.push_back(static_cast<float>(0.07 * k), static_cast<float>(std::sin(0.3 * k)),
                       static_cast<float>(s));
    }
    points.points = fleet::PackedPoints(arrays);
    fact.body = points;
  }
  return fact;
}

/// Vehicles that make facts and exchange them over a loopback, in steps of 0.1 s.
class TestFleet {
 public:
  TestFleet(std::uint16_t vehicles, const LinkSettings& link, std::uint64_t seed,
            const fleet::ExchangeSettings& settings)
      : ids_(ids_of(vehicles)), radio(ids_, link, seed) {
    for (const VehicleId id : ids_) {
      nodes_.emplace(id, Node{fleet::FactStore(id, ids_), fleet::Exchange(id, ids_, settings), {}});
    }
  }

  static std::vector<VehicleId> ids_of(std::uint16_t n) {
    std::vector<VehicleId> ids;
    for (std::uint16_t k = 0; k < n; ++k) ids.push_back(VehicleId{k});
    return ids;
  }

  void make_fact(VehicleId id) {
    Node& node = nodes_.at(id);
    EXPECT_TRUE(node.store.add_own(some_fact(id, node.made++, now_)));
  }

  void step() {
    now_ = now_ + Duration::from_s(0.1);
    const Mail mail = collect(radio, now_);
    EXPECT_EQ(mail.unreadable, 0U);
    for (const Received& received : mail.received) {
      Node& node = nodes_.at(received.to);
      node.exchange.receive(received.envelope, node.store, now_);
    }
    for (auto& [id, node] : nodes_) {
      if (!radio.alive(id)) continue;
      for (const fleet::FactPtr& fact : node.store.take_new()) {
        EXPECT_TRUE(node.delivered.insert(fact->key).second) << "a fact was delivered twice";
      }
      for (const fleet::Envelope& envelope : node.exchange.step(node.store, now_)) {
        EXPECT_TRUE(post(radio, now_, envelope));
      }
    }
  }

  void run_until(double t_s) {
    while (now_.s() < t_s - 1e-6) step();
  }

  [[nodiscard]] const fleet::FactStore& store(std::uint16_t id) const {
    return nodes_.at(VehicleId{id}).store;
  }

  [[nodiscard]] fleet::Exchange& exchange(std::uint16_t id) {
    return nodes_.at(VehicleId{id}).exchange;
  }

  [[nodiscard]] std::size_t delivered(std::uint16_t id) const {
    return nodes_.at(VehicleId{id}).delivered.size();
  }

  /// True if all living vehicles hold the same facts.
  [[nodiscard]] bool agree() const {
    std::set<std::uint64_t> hashes;
    for (const auto& [id, node] : nodes_) {
      if (radio.alive(id)) hashes.insert(node.store.hash());
    }
    return hashes.size() == 1;
  }

  /// Facts sent, over all links.
  [[nodiscard]] std::uint64_t facts_sent() const {
    std::uint64_t sum = 0;
    const fleet::TrafficCount sent = radio.sent();
    for (std::uint8_t k = 0; k < fleet::kFactKinds; ++k) {
      sum += sent[static_cast<fleet::Kind>(k)].messages;
    }
    return sum;
  }

  [[nodiscard]] Time now() const { return now_; }

 private:
  struct Node {
    fleet::FactStore store;
    fleet::Exchange exchange;
    std::set<fleet::FactKey> delivered;
    std::uint32_t made = 0;
  };

  std::vector<VehicleId> ids_;

 public:
  Loopback radio;

 private:
  std::map<VehicleId, Node> nodes_;
  Time now_;
};

}  // namespace rali::drive
