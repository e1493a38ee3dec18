#pragma once

// One vehicle whose role machine is given events by hand, for the tests of this folder.

#include <vector>

#include <gtest/gtest.h>

#include "rali/fleet/roles/role_fleet_for_test.hpp"

namespace rali::fleet::test {

inline const RoleSettings kSettings;
inline constexpr double kPromise_s = 5.0 * 1.02 / 0.98;  // 5.204

inline Time at(double t_s) { return Time::from_s(t_s); }

/// A vehicle of a fleet of three at standstill since long before time 0.
class Vehicle {
 public:
  explicit Vehicle(int self, const DurableRole& durable = durable_of(3), double now_s = 0.0)
      : state(start_role(id(self), durable, kSettings, at(now_s))) {
    state.standing_since = at(now_s - 100.0);
  }

  RoleStep give(double t_s, const RoleEvent& event) {
    RoleStep step = role_step(state, kSettings, event, at(t_s));
    EXPECT_EQ(step.save, !(step.state.durable == state.durable));
    state = step.state;
    return step;
  }

  RoleStep receive(double t_s, int from, RoleOp op, std::uint64_t term, int candidate = 0,
                   double echo_s = 0.0) {
    RoleMessage m;
    m.op = op;
    m.term = term;
    m.candidate = id(candidate);
    m.t_send = at(t_s);
    m.t_echo = at(echo_s);
    return give(t_s, RoleReceived{id(from), m});
  }

  RoleStep tick(double t_s) { return give(t_s, RoleTick{}); }

  RoleState state;
};

inline std::vector<RoleOp> ops(const RoleStep& step) {
  std::vector<RoleOp> out;
  for (const RoleSend& s : step.messages) out.push_back(s.message.op);
  return out;
}

inline bool has(const RoleStep& step, RoleActionKind kind) {
  for (const RoleAction& a : step.actions) {
    if (a.kind == kind) return true;
  }
  return false;
}

using Ops = std::vector<RoleOp>;

/// v0 as anchor of term 1 since t = 0, with the vote of v1.
inline Vehicle anchor_of_three() {
  Vehicle v(0);
  v.give(0.0, RoleClaim{});
  v.receive(0.1, 1, RoleOp::kGrant, 1, 0, 0.0);
  EXPECT_EQ(v.state.mode, RoleMode::kAnchor);
  return v;
}

/// v1 as tag of anchor v0 in term 1 since t = 0.
inline Vehicle tag_of_three() {
  Vehicle v(1);
  v.receive(0.0, 0, RoleOp::kCommit, 1);
  return v;
}

}  // namespace rali::fleet::test
