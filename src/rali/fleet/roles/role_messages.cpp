#include <algorithm>
#include <utility>

#include "rali/fleet/roles/role_stepper.hpp"

namespace rali::fleet::detail {
namespace {

/// A term beyond this jump is not from this fleet: it would exhaust the numbers for later terms.
constexpr std::uint64_t kTermJumpMax = std::uint64_t{1} << 32;

}  // namespace

void RoleStepper::on(const RoleReceived& event) {
  const RoleMessage& m = event.message;
  if (event.from == state().self || !in_fleet(event.from)) return;
  if (m.term > state().durable.term && m.term - state().durable.term > kTermJumpMax) return;
  state().link_received = now_;
  switch (m.op) {
    case RoleOp::kHeartbeat:
    case RoleOp::kCommit:
      return receive_anchor(event.from, m);
    case RoleOp::kSeal:
      return receive_seal(event.from, m);
    case RoleOp::kAck:
      return receive_ack(event.from, m);
    case RoleOp::kFinished:
      return receive_finished(event.from, m);
    case RoleOp::kHandover:
      return receive_handover(event.from, m);
    case RoleOp::kPropose:
      return receive_propose(event.from, m);
    case RoleOp::kGrant:
      return receive_grant(event.from, m);
    case RoleOp::kRefuse:
      return receive_refuse(event.from, m);
  }
}

void RoleStepper::receive_anchor(VehicleId from, const RoleMessage& m) {
  if (m.term < state().durable.term) {
    RoleMessage refusal = message(RoleOp::kRefuse);
    refusal.candidate = from;
    return send(from, std::move(refusal));
  }
  if (m.term == state().durable.term && state().durable.anchor && *state().durable.anchor != from) {
    return act(RoleActionKind::kConflict, from);
  }
  if (m.term > state().durable.term || !state().durable.anchor) follow(from, m.term);
  if (state().seal_received) return;  // an old heartbeat that arrived late
  state().promise_until = now_ + promise();
  wait_for_anchor();
  if (state().orphan) {
    state().orphan = false;
    act(RoleActionKind::kRejoined, from);
  }
  RoleMessage ack = message(RoleOp::kAck);
  ack.candidate = from;
  ack.t_echo = m.t_send;
  ack.t_received = now_;
  send(from, std::move(ack));
  if (state().finished == FinishReason::kNone) return;
  RoleMessage finished = message(RoleOp::kFinished);
  finished.reason = state().finished;
  send(from, std::move(finished));
}

/// I7. A new anchor starts a new round; the same one in a new term continues the old round.
void RoleStepper::follow(VehicleId anchor, std::uint64_t term) {
  const bool was_anchor = state().mode == RoleMode::kAnchor || state().mode == RoleMode::kSealed;
  if (state().mode == RoleMode::kAnchor) act(RoleActionKind::kStoppedAnchoring, state().self);
  if (was_anchor) {
    state().stands_for = anchor;
    state().stands_until = now_ + Duration::from_s(settings_.leave_s);
  }
  const bool same = state().followed == anchor && !state().seal_received;
  if (term > state().durable.term) state().durable.granted_to.reset();
  state().durable.term = term;
  state().durable.anchor = anchor;
  step_.save = true;
  state().mode = RoleMode::kTag;
  state().renews = false;
  state().seal_received = false;
  state().attempts = 0;
  state().followed = anchor;
  state().peers.clear();
  if (same) return;
  state().finished = FinishReason::kNone;
  act(RoleActionKind::kFollows, anchor);
}

void RoleStepper::receive_seal(VehicleId from, const RoleMessage& m) {
  if (m.term < state().durable.term) return;
  if (m.term > state().durable.term || !state().durable.anchor) follow(from, m.term);
  if (*state().durable.anchor != from) return act(RoleActionKind::kConflict, from);
  state().seal_received = true;
  wait_for_anchor();
}

void RoleStepper::receive_ack(VehicleId from, const RoleMessage& m) {
  RolePeer* p = peer(from);
  if (state().mode != RoleMode::kAnchor || p == nullptr || m.term != state().durable.term) return;
  if (m.t_echo > now_) return;  // of this vehicle's clock before a restart
  if (!p->echoed || m.t_echo > *p->echoed) p->echoed = m.t_echo;
  p->received = now_;
  renew_lease();
}

void RoleStepper::receive_finished(VehicleId from, const RoleMessage& m) {
  RolePeer* p = peer(from);
  if (state().mode != RoleMode::kAnchor || p == nullptr || m.term != state().durable.term) return;
  if (m.t_send < p->finished_sent) return;
  p->finished = m.reason;
  p->finished_sent = m.t_send;
}

void RoleStepper::receive_handover(VehicleId from, const RoleMessage& m) {
  if (m.candidate != state().self) return;
  if (m.term == state().durable.term && state().durable.granted_to == state().self) return;
  if (m.term <= state().durable.term) {
    RoleMessage refusal = message(RoleOp::kRefuse);
    refusal.candidate = from;
    return send(from, std::move(refusal));
  }
  // Only a sealed anchor hands over, but the receiver may follow its successor already.
  const bool sealed = state().seal_received || state().durable.anchor == from;
  if (state().mode != RoleMode::kTag || !(sealed || now_ >= state().promise_until)) return;
  if (sealed) state().seal_received = true;
  if (!stands() || !state().durable.confirmed || !state().eligible) return;  // it is repeated
  stand_for(m.term, false);
}

bool RoleStepper::may_grant(VehicleId candidate) const {
  if (!state().durable.confirmed) return false;
  if (state().mode == RoleMode::kAnchor) return now_ >= state().lease_until;
  if (state().mode == RoleMode::kSealed || state().mode == RoleMode::kCandidate) return true;
  // The vehicle that the promise protects no longer acts in the old term when it asks for a new.
  const auto promised =
      state().durable.anchor ? state().durable.anchor : state().durable.granted_to;
  return state().seal_received || now_ >= state().promise_until || promised == candidate;
}

void RoleStepper::receive_propose(VehicleId from, const RoleMessage& m) {
  const bool again = m.term == state().durable.term && state().durable.granted_to == from;
  const bool ok =
      m.candidate == from && (again || (m.term > state().durable.term && may_grant(from)));
  if (!ok) {
    RoleMessage refusal = message(RoleOp::kRefuse);
    refusal.candidate = from;
    return send(from, std::move(refusal));
  }
  if (!again) grant(from, m.term);
  state().promise_until = now_ + promise();
  wait_for_anchor();
  RoleMessage vote = message(RoleOp::kGrant);
  vote.candidate = from;
  vote.t_echo = m.t_send;
  vote.t_received = now_;
  send(from, std::move(vote));
}

void RoleStepper::grant(VehicleId candidate, std::uint64_t term) {
  if (state().mode == RoleMode::kAnchor) act(RoleActionKind::kStoppedAnchoring, state().self);
  if (state().mode == RoleMode::kAnchor || state().mode == RoleMode::kSealed) {
    state().stands_for = candidate;
    state().stands_until = now_ + Duration::from_s(settings_.leave_s);
    state().followed.reset();
  }
  if (state().seal_received) state().followed.reset();
  state().durable.term = term;
  state().durable.granted_to = candidate;
  state().durable.anchor.reset();
  step_.save = true;
  state().mode = RoleMode::kTag;
  state().renews = false;
  state().seal_received = false;
  state().peers.clear();
}

void RoleStepper::receive_grant(VehicleId from, const RoleMessage& m) {
  RolePeer* p = peer(from);
  const bool mine = m.term == state().durable.term && m.candidate == state().self;
  const bool asks = state().mode == RoleMode::kCandidate || state().mode == RoleMode::kAnchor;
  if (p == nullptr || !mine || !asks || m.t_echo > now_) return;
  p->granted = true;
  if (!p->echoed || m.t_echo > *p->echoed) p->echoed = m.t_echo;
  p->received = now_;
  if (state().mode == RoleMode::kAnchor) return renew_lease();
  commit_if_majority();
}

void RoleStepper::receive_refuse(VehicleId from, const RoleMessage& m) {
  static_cast<void>(from);
  if (m.term <= state().durable.term || m.candidate != state().self) return;
  switch (state().mode) {
    case RoleMode::kTag:
      return;  // late; messages of the anchor of the higher term will arrive
    case RoleMode::kCandidate:
      if (state().renews && stands()) return stand_for(m.term + 1, true);
      state().durable.term = m.term;
      state().durable.granted_to.reset();
      state().durable.anchor.reset();
      step_.save = true;
      state().mode = RoleMode::kTag;
      state().renews = false;
      ++state().attempts;
      state().takeover_at = now_ + Duration::from_s(settings_.lease_s * (1.0 + 2.0 * chance()));
      return;
    case RoleMode::kAnchor:
      // A candidate lost an election; its term is used up. With a new term of its own the anchor
      // gets that vehicle back without ending the round: all promises were made to this anchor.
      if (stands()) stand_for(m.term + 1, true);
      return;
    case RoleMode::kSealed:
      state().handover_term = std::max(state().handover_term, m.term);
      return;
  }
}

}  // namespace rali::fleet::detail
