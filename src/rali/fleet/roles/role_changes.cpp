#include <algorithm>
#include <limits>
#include <utility>

#include "rali/fleet/roles/role_stepper.hpp"

namespace rali::fleet::detail {

void RoleStepper::stand_for(std::uint64_t term, bool renews) {
  if (state().mode == RoleMode::kAnchor) act(RoleActionKind::kStoppedAnchoring, state().self);
  state().durable.term = term;
  state().durable.granted_to = state().self;
  state().durable.anchor.reset();
  step_.save = true;
  if (state().seal_received || state().mode == RoleMode::kSealed) state().followed.reset();
  state().mode = RoleMode::kCandidate;
  state().renews = renews;
  state().seal_received = false;
  state().promise_until = now_ + promise();
  state().candidate_until = now_ + lease() + lease();
  reset_peers();
  send_propose();
  commit_if_majority();
}

void RoleStepper::commit_if_majority() {
  std::size_t votes = 1;  // its own
  for (const RolePeer& p : state().peers) votes += p.granted ? 1 : 0;
  if (state().mode != RoleMode::kCandidate || votes < quorum()) return;
  const bool renewed = state().renews;
  state().mode = RoleMode::kAnchor;
  state().durable.anchor = state().self;
  step_.save = true;
  state().renews = false;
  state().orphan = false;
  state().seal_received = false;
  state().attempts = 0;
  state().followed = state().self;
  state().stands_for.reset();
  if (!renewed) {
    state().anchor_since = now_;
    state().finished = FinishReason::kNone;
  }
  renew_lease();
  act(renewed ? RoleActionKind::kRenewedTerm : RoleActionKind::kBecameAnchor, state().self);
  RoleMessage m = message(RoleOp::kCommit);
  m.lease = lease();
  send(std::nullopt, std::move(m));
  state().next_send = now_ + Duration::from_s(settings_.heartbeat_s);
}

/// The lease lasts L from the newest message that a majority, itself included, has answered: each
/// of them made its promise at or after the sending time.
void RoleStepper::renew_lease() {
  std::vector<Time> echoes = {now_};
  for (const RolePeer& p : state().peers) {
    if (p.echoed) echoes.push_back(*p.echoed);
  }
  if (echoes.size() < quorum()) return;
  std::sort(echoes.begin(), echoes.end(), std::greater<>());
  state().lease_until = std::max(state().lease_until, echoes[quorum() - 1] + lease());
}

void RoleStepper::reset_peers() {
  // Finished tags stay finished while the same anchor only takes a new term.
  const std::vector<RolePeer> before = std::move(state().peers);
  state().peers.clear();
  for (const VehicleId vehicle : state().durable.fleet) {
    if (vehicle == state().self) continue;
    RolePeer p;
    p.vehicle = vehicle;
    for (const RolePeer& old : before) {
      if (!state().renews || old.vehicle != vehicle) continue;
      p.finished = old.finished;
      p.finished_sent = old.finished_sent;
    }
    state().peers.push_back(p);
  }
  state().lease_until = Time::from_ns(std::numeric_limits<std::int64_t>::min());
}

void RoleStepper::seal() {
  act(RoleActionKind::kStoppedAnchoring, state().self);
  act(RoleActionKind::kSealed, state().self);
  state().mode = RoleMode::kSealed;
  state().choice.clear();
  state().tried.clear();
  state().named.reset();
  state().handover_term = state().durable.term;
  state().handover_until = now_ + Duration::from_s(6.0 * settings_.lease_s);
  state().next_send = now_ + Duration::from_s(settings_.heartbeat_s);
  send(std::nullopt, message(RoleOp::kSeal));
}

void RoleStepper::step_down() {
  act(RoleActionKind::kStoppedAnchoring, state().self);
  act(RoleActionKind::kOrphaned, state().self);
  state().mode = RoleMode::kTag;
  state().orphan = true;
  // Its last promise to itself expires: it may become candidate again like any other.
  wait_for_anchor();
}

/// Names the best candidate not named yet; after the last one itself, which needs no transfer.
void RoleStepper::name_next() {
  state().named.reset();
  for (const VehicleId v : state().choice) {
    const auto& tried = state().tried;
    if (!in_fleet(v) || std::find(tried.begin(), tried.end(), v) != tried.end()) continue;
    state().named = v;
    break;
  }
  ++state().handover_term;
  state().handover_until = now_ + Duration::from_s(3.0 * settings_.lease_s);
  state().next_send = now_;
  if (state().named && *state().named != state().self) {
    state().tried.push_back(*state().named);
    return;
  }
  state().named.reset();
  if (stands() && state().durable.confirmed) return stand_for(state().handover_term, false);
  // Moved while sealed: a vehicle that receives no anchor messages takes over.
  state().mode = RoleMode::kTag;
  state().orphan = true;
  act(RoleActionKind::kOrphaned, state().self);
  wait_for_anchor();
}

void RoleStepper::wait_for_anchor() {
  const double rate = settings_.clock_rate;
  state().takeover_at =
      now_ + Duration::from_s(settings_.lease_s * (2.0 * (1.0 + rate) + chance()));
}

void RoleStepper::send(std::optional<VehicleId> to, RoleMessage m) {
  m.t_send = now_;
  step_.messages.push_back({to, std::move(m)});
}

void RoleStepper::send_propose() {
  state().next_send = now_ + Duration::from_s(settings_.heartbeat_s);
  RoleMessage m = message(RoleOp::kPropose);
  m.candidate = state().self;
  send(std::nullopt, std::move(m));
}

void RoleStepper::act(RoleActionKind kind, VehicleId vehicle) {
  step_.actions.push_back({kind, state().durable.term, vehicle});
}

RoleMessage RoleStepper::message(RoleOp op) const {
  RoleMessage m;
  m.op = op;
  m.term = state().durable.term;
  m.candidate = state().self;
  return m;
}

RolePeer* RoleStepper::peer(VehicleId vehicle) {
  for (RolePeer& p : state().peers) {
    if (p.vehicle == vehicle) return &p;
  }
  return nullptr;
}

}  // namespace rali::fleet::detail
