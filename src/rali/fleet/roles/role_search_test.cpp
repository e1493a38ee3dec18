// T23: exhaustive search of all voting behaviours of a small fleet, with the machine itself. Leases
// are zero and the clock does not advance, so every guard of time is open and every time-out may
// happen at once: more behaviours than real ones. Messages stay pending for good: they may arrive
// never, late, twice, in any order.
#include <array>
#include <deque>
#include <numeric>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "rali/fleet/roles/role_fleet_for_test.hpp"

namespace rali::fleet {
namespace {

using test::fleet_of;
using test::id;

struct Plan {
  int vehicles = 3;
  std::uint64_t terms = 3;
  int restarts = 1;
  bool seals = false;                               ///< rounds end and are handed over, too
  bool forgets = false;                             ///< mutant: the disk stores nothing
  std::vector<std::vector<VehicleId>> fleets = {};  ///< mutants: the fleet that each one counts
};

/// A pending message: op, from, to (0 all), term, candidate; vehicles are counted from 1.
struct Air {
  std::uint8_t op, from, to, term, candidate;
  auto operator<=>(const Air&) const = default;
};

struct Node {
  std::vector<RoleState> vehicles;
  std::vector<Air> air;                      ///< ascending
  std::array<std::uint8_t, 8> anchors = {};  ///< by term: which vehicle was ever committed, from 1
  int restarts = 0;
};

using Key = std::basic_string<std::uint8_t>;
using Names = std::array<std::uint8_t, 8>;  ///< new number of each vehicle, both from 1; 0 is 0

void add_vehicle(Key& key, const RoleState& s, const Names& names) {
  const auto name = [&names](const std::optional<VehicleId>& v) {
    return v ? names[v->value + 1U] : std::uint8_t{0};
  };
  key.push_back(static_cast<std::uint8_t>(s.mode));
  key.push_back(static_cast<std::uint8_t>(s.durable.term));
  key.push_back(name(s.durable.granted_to));
  key.push_back(name(s.durable.anchor));
  key.push_back(s.seal_received ? 1 : 0);
  key.push_back(name(s.named));
  key.push_back(s.mode == RoleMode::kSealed ? static_cast<std::uint8_t>(s.handover_term) : 0);
  key.push_back(static_cast<std::uint8_t>(s.tried.size()));
  // Votes count only for the candidate that asks for them, and have no other effect.
  std::uint8_t votes = 0;
  for (const RolePeer& p : s.peers) {
    const bool counts = s.mode == RoleMode::kCandidate && p.granted;
    if (counts) votes = static_cast<std::uint8_t>(votes | 1U << names[p.vehicle.value + 1U]);
  }
  key.push_back(votes);
}

Key key_of(const Node& node, const Names& names) {
  Key key(1, static_cast<std::uint8_t>(node.restarts));
  for (std::size_t place = 1; place <= node.vehicles.size(); ++place) {
    for (std::size_t v = 0; v < node.vehicles.size(); ++v) {
      if (names[v + 1] == place) add_vehicle(key, node.vehicles[v], names);
    }
  }
  for (const std::uint8_t anchor : node.anchors) key.push_back(names[anchor]);
  std::vector<Air> air = node.air;
  for (Air& m : air) m = {m.op, names[m.from], names[m.to], m.term, names[m.candidate]};
  std::sort(air.begin(), air.end());
  for (const Air& m : air) key.insert(key.end(), {m.op, m.from, m.to, m.term, m.candidate});
  return key;
}

/// The same for states that differ only in the vehicles' numbers.
Key smallest_key(const Node& node) {
  Names names = {};
  const auto n = static_cast<std::ptrdiff_t>(node.vehicles.size());
  std::iota(names.begin() + 1, names.begin() + 1 + n, std::uint8_t{1});
  Key smallest = key_of(node, names);
  while (std::next_permutation(names.begin() + 1, names.begin() + 1 + n)) {
    smallest = std::min(smallest, key_of(node, names));
  }
  return smallest;
}

class Search {
 public:
  explicit Search(const Plan& plan) : plan_(plan) {
    settings_.lease_s = settings_.heartbeat_s = settings_.stand_s = settings_.leave_s = 0.0;
    settings_.round_timeout_s = 1.0;  // never: the clock does not advance
    Node node;
    for (int v = 0; v < plan.vehicles; ++v) node.vehicles.push_back(fresh(v, durable(v)));
    push(node);
    while (!open_.empty() && violations == 0) {
      const Node next = open_.front();
      open_.pop_front();
      expand(next);
    }
  }

  std::size_t states = 0;
  int violations = 0;
  std::uint64_t commits = 0;

 private:
  [[nodiscard]] DurableRole durable(int v) const {
    DurableRole d = test::durable_of(plan_.vehicles);
    if (!plan_.fleets.empty()) d.fleet = plan_.fleets[static_cast<std::size_t>(v)];
    return d;
  }

  [[nodiscard]] RoleState fresh(int v, const DurableRole& disk) const {
    RoleState s = start_role(id(v), disk, settings_, Time{});
    s.standing_since = Time{};
    s.link_received = Time{};
    return s;
  }

  void push(Node node) {
    // A mutant whose vehicles count different fleets is not symmetric under renumbering.
    const bool alike = plan_.fleets.empty() && !plan_.seals;
    Names same = {0, 1, 2, 3, 4, 5, 6, 7};
    if (!seen_.insert(alike ? smallest_key(node) : key_of(node, same)).second) return;
    ++states;
    open_.push_back(std::move(node));
  }

  void give(Node node, int v, const RoleEvent& event) {
    auto& state = node.vehicles[static_cast<std::size_t>(v)];
    const RoleStep step = role_step(state, settings_, event, Time{});
    EXPECT_GE(step.state.durable.term, state.durable.term) << "I2";
    EXPECT_TRUE(step.save || step.state.durable == state.durable);
    if (step.state.durable.term > plan_.terms) return;
    const bool votes = step.state.peers.size() == state.peers.size() && !state.peers.empty();
    if (!plan_.seals && !votes && !step.save && step.state.mode == state.mode) return;  // no change
    state = step.state;
    for (const RoleAction& a : step.actions) {
      if (a.kind != RoleActionKind::kBecameAnchor) continue;
      ++commits;
      std::uint8_t& anchor = node.anchors[a.term];
      if (anchor != 0 && anchor != v + 1) ++violations;
      anchor = static_cast<std::uint8_t>(v + 1);
    }
    if (!plan_.seals) state.durable.anchor.reset();  // then only the conflict check reads it
    for (const RoleSend& s : step.messages) keep(node, v, s);
    push(std::move(node));
  }

  void keep(Node& node, int from, const RoleSend& s) const {
    const RoleOp op = s.message.op;
    if (op == RoleOp::kHeartbeat || op == RoleOp::kAck || op == RoleOp::kFinished) return;
    if (op == RoleOp::kRefuse) return;  // raises terms only, as ticks do
    const auto byte = [](auto v) { return static_cast<std::uint8_t>(v); };
    const Air m = {byte(op), byte(from + 1), byte(s.to ? s.to->value + 1 : 0), byte(s.message.term),
                   byte(s.message.candidate.value + 1)};
    const auto at = std::lower_bound(node.air.begin(), node.air.end(), m);
    if (at == node.air.end() || *at != m) node.air.insert(at, m);
  }

  void expand(const Node& node) {
    for (int v = 0; v < plan_.vehicles; ++v) {
      give(node, v, RoleTick{});
      const RoleState& s = node.vehicles[static_cast<std::size_t>(v)];
      if (plan_.seals && s.mode == RoleMode::kAnchor) give(node, v, RoleEndRound{});
      if (plan_.seals && s.mode == RoleMode::kSealed) {
        give(node, v, RoleChoice{{id((v + 1) % plan_.vehicles), id((v + 2) % plan_.vehicles)}});
      }
      if (node.restarts >= plan_.restarts) continue;
      Node again = node;
      ++again.restarts;
      again.vehicles[static_cast<std::size_t>(v)] =
          fresh(v, plan_.forgets ? durable(v) : s.durable);
      push(again);
    }
    for (const Air& m : node.air) {
      RoleMessage message;
      message.op = static_cast<RoleOp>(m.op);
      message.term = m.term;
      message.candidate = id(m.candidate - 1);
      for (int v = 0; v < plan_.vehicles; ++v) {
        const bool addressed = v + 1 != m.from && (m.to == 0 || m.to == v + 1);
        if (addressed) give(node, v, RoleReceived{id(m.from - 1), message});
      }
    }
  }

  Plan plan_;
  RoleSettings settings_;
  std::set<Key> seen_;
  std::deque<Node> open_;
};

/// No state of the plan may hold two anchors of one term.
void expect_one_anchor_per_term(const Plan& plan, std::size_t states_min) {
  const Search search(plan);
  EXPECT_EQ(search.violations, 0);
  EXPECT_GT(search.commits, 10U) << "without anchors it proves nothing";
  EXPECT_GT(search.states, states_min) << "behaviours went missing";
}

TEST(RoleSearch, of_three_vehicles_and_three_terms_finds_no_two_anchors_in_a_term) {
  expect_one_anchor_per_term({3, 3, 1}, 10'000);
}

TEST(RoleSearch, of_four_vehicles_and_two_terms_finds_no_two_anchors_in_a_term) {
  expect_one_anchor_per_term({4, 2, 0}, 1'000);
}

TEST(RoleSearch, of_two_vehicles_finds_no_two_anchors_in_a_term) {
  expect_one_anchor_per_term({2, 3, 2}, 100);
}

TEST(RoleSearch, of_rounds_that_are_handed_over_finds_no_two_anchors_in_a_term) {
  expect_one_anchor_per_term({3, 2, 0, true}, 1'000);
}

TEST(RoleSearch, finds_two_anchors_if_one_vote_is_enough) {
  Plan plan;
  plan.fleets = {{id(0)}, {id(1)}, {id(2)}};
  EXPECT_GT(Search(plan).violations, 0);
}

TEST(RoleSearch, finds_two_anchors_if_a_vote_is_lost_in_a_restart) {
  Plan plan;
  plan.forgets = true;
  EXPECT_GT(Search(plan).violations, 0);
}

TEST(RoleSearch, finds_two_anchors_if_two_of_four_votes_are_enough) {
  Plan plan;
  plan.vehicles = 4;
  plan.fleets = {{id(0), id(1)}, {id(0), id(1)}, {id(2), id(3)}, {id(2), id(3)}};
  EXPECT_GT(Search(plan).violations, 0);
}

}  // namespace
}  // namespace rali::fleet
