#pragma once

// Vehicles whose role machines communicate over an unreliable radio, for the tests of this folder.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/fleet/roles/role_machine.hpp"

namespace rali::fleet::test {

inline VehicleId id(int v) { return VehicleId{static_cast<std::uint16_t>(v)}; }

inline std::vector<VehicleId> fleet_of(int n) {
  std::vector<VehicleId> fleet;
  for (int v = 0; v < n; ++v) fleet.push_back(id(v));
  return fleet;
}

inline DurableRole durable_of(int n, std::uint64_t term = 0) {
  DurableRole d;
  d.term = term;
  d.fleet = fleet_of(n);
  return d;
}

struct Radio {
  double loss = 0.0;
  double repeat = 0.0;       ///< fraction of messages that arrive twice
  double delay_max_s = 0.0;  ///< uniform
};

class RoleFleetSim {
 public:
  RoleFleetSim(int n, std::uint64_t seed, const RoleSettings& settings = {})
      : settings_(settings), rng_(seed, "roles.test") {
    for (int v = 0; v < n; ++v) {
      Node node;
      node.rate = 1.0 + settings.clock_rate * rng_.uniform(-1.0, 1.0);
      node.offset_s = rng_.uniform(0.0, 1e4);
      node.disk = durable_of(n);
      nodes_.push_back(node);
      restart(v);
    }
  }

  struct Node {
    double rate = 1.0, offset_s = 0.0;
    bool alive = true;
    int side = 0;  ///< of a partition
    bool moves = false;
    DurableRole disk;
    RoleState state;
    std::vector<RoleActionKind> actions;
  };

  struct Flight {
    double at_s;
    std::uint64_t order;
    int from, to;
    RoleMessage message;
  };

  [[nodiscard]] Time clock(int v) const {
    const Node& n = nodes_[static_cast<std::size_t>(v)];
    return Time::from_s(n.offset_s + n.rate * now_s_);
  }

  void restart(int v) {
    Node& n = node(v);
    n.state = start_role(id(v), n.disk, settings_, clock(v));
    n.alive = true;
    give(v, RoleSelf{clock(v) - Duration::from_s(100.0), 20});
  }

  void kill(int v) { node(v).alive = false; }

  Node& node(int v) { return nodes_[static_cast<std::size_t>(v)]; }

  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }

  void give(int v, const RoleEvent& event) {
    Node& n = node(v);
    if (!n.alive) return;
    const std::uint64_t term = n.state.durable.term;
    RoleStep step = role_step(n.state, settings_, event, clock(v));
    EXPECT_GE(step.state.durable.term, term) << "I2";
    n.state = step.state;
    if (step.save) n.disk = step.state.durable;
    EXPECT_EQ(n.disk, n.state.durable) << "changed without a save";
    for (const RoleAction& a : step.actions) {
      n.actions.push_back(a.kind);
      if (a.kind == RoleActionKind::kConflict) ++conflicts;
      if (a.kind == RoleActionKind::kSealed) wants_choice_.insert(v);
      if (a.kind == RoleActionKind::kBecameAnchor || a.kind == RoleActionKind::kRenewedTerm) {
        commits.push_back({a.term, v, now_s_});
      }
    }
    for (const RoleSend& s : step.messages) post(v, s);
    check();
  }

  /// One step of true time: all messages that are due, then every vehicle's tick.
  void advance(double dt_s) {
    now_s_ += dt_s;
    std::sort(air_.begin(), air_.end(), [](const Flight& a, const Flight& b) {
      return a.at_s != b.at_s ? a.at_s < b.at_s : a.order < b.order;
    });
    std::vector<Flight> due;
    std::size_t k = 0;
    while (k < air_.size() && air_[k].at_s <= now_s_) due.push_back(air_[k++]);
    air_.erase(air_.begin(), air_.begin() + static_cast<std::ptrdiff_t>(k));
    for (const Flight& f : due) {
      if (linked(f.from, f.to)) give(f.to, RoleReceived{id(f.from), f.message});
    }
    for (int v = 0; v < size(); ++v) {
      for (int w = 0; w < size(); ++w) {
        if (v != w && node(w).alive && linked(w, v)) give(v, RoleLink{id(w)});
      }
      give(v, RoleTick{});
    }
    answer_seals();
  }

  void run(double duration_s, double dt_s = 0.5) {
    for (double t = 0.0; t < duration_s; t += dt_s) advance(dt_s);
  }

  [[nodiscard]] std::optional<int> acting_anchor() {
    for (int v = 0; v < size(); ++v) {
      if (node(v).alive && may_publish(node(v).state, clock(v))) return v;
    }
    return std::nullopt;
  }

  void expect_one_anchor_at_a_time() {
    int acting = 0;
    for (int v = 0; v < size(); ++v) {
      acting += node(v).alive && may_publish(node(v).state, clock(v)) ? 1 : 0;
    }
    if (acting > 1) ++overlaps;
  }

  struct Commit {
    std::uint64_t term;
    int vehicle;
    double at_s;
  };

  std::vector<Commit> commits;
  Radio radio;
  int conflicts = 0;
  int overlaps = 0;
  int two_in_a_term = 0;

  [[nodiscard]] double now_s() const { return now_s_; }

  Rng& rng() { return rng_; }

 private:
  [[nodiscard]] bool linked(int a, int b) { return node(a).side == node(b).side; }

  void post(int from, const RoleSend& s) {
    for (int v = 0; v < size(); ++v) {
      if (v == from || (s.to && *s.to != id(v))) continue;
      const int copies = rng_.uniform() < radio.repeat ? 2 : 1;
      for (int c = 0; c < copies; ++c) {
        if (rng_.uniform() < radio.loss || !linked(from, v)) continue;
        air_.push_back({now_s_ + rng_.uniform() * radio.delay_max_s, order_++, from, v, s.message});
      }
    }
  }

  void answer_seals() {
    for (const int v : wants_choice_) {
      std::vector<VehicleId> ranked;
      for (int w = 1; w <= size(); ++w) ranked.push_back(id((v + w) % size()));
      give(v, RoleChoice{ranked});
    }
    wants_choice_.clear();
  }

  void check() {
    expect_one_anchor_at_a_time();
    for (; checked_ < commits.size(); ++checked_) {
      for (std::size_t i = 0; i < checked_; ++i) {
        const bool both = commits[i].term == commits[checked_].term;
        if (both && commits[i].vehicle != commits[checked_].vehicle) ++two_in_a_term;
      }
    }
  }

  RoleSettings settings_;
  Rng rng_;
  std::vector<Node> nodes_;
  std::vector<Flight> air_;
  std::set<int> wants_choice_;
  std::uint64_t order_ = 0;
  std::size_t checked_ = 0;
  double now_s_ = 0.0;
};

}  // namespace rali::fleet::test
