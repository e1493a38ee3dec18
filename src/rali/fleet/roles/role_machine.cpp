#include "rali/fleet/roles/role_machine.hpp"

#include <algorithm>
#include <utility>

#include "rali/base/rng.hpp"
#include "rali/fleet/roles/role_stepper.hpp"

namespace rali::fleet {
namespace detail {

void RoleStepper::on(const RoleTick&) {
  switch (state().mode) {
    case RoleMode::kTag:
      return tick_tag();
    case RoleMode::kCandidate:
      return tick_candidate();
    case RoleMode::kAnchor:
      return tick_anchor();
    case RoleMode::kSealed:
      return tick_sealed();
  }
}

void RoleStepper::tick_tag() {
  if (state().stands_for && now_ >= state().stands_until) {
    state().stands_for.reset();
    act(RoleActionKind::kMayLeave, state().self);
  }
  if (!state().orphan && !state().seal_received && now_ >= state().promise_until) {
    state().orphan = true;
    act(RoleActionKind::kOrphaned, state().self);
  }
  const bool promised = now_ < state().promise_until && !state().seal_received;
  if (now_ >= state().takeover_at && !promised && may_stand_for_election()) {
    stand_for(state().durable.term + 1, false);
  }
}

void RoleStepper::tick_candidate() {
  if (now_ >= state().candidate_until) {
    state().mode = RoleMode::kTag;
    state().renews = false;
    ++state().attempts;
    state().takeover_at = now_ + Duration::from_s(settings_.lease_s * (1.0 + 2.0 * chance()));
    return;
  }
  if (now_ >= state().next_send) send_propose();
}

void RoleStepper::tick_anchor() {
  renew_lease();
  if (now_ >= state().lease_until) return step_down();
  const double round_s = seconds_between(state().anchor_since, now_);
  if (all_finished() || round_s >= settings_.round_timeout_s) return seal();
  if (now_ < state().next_send) return;
  state().next_send = now_ + Duration::from_s(settings_.heartbeat_s);
  RoleMessage m = message(RoleOp::kHeartbeat);
  m.lease = lease();
  send(std::nullopt, std::move(m));
}

void RoleStepper::tick_sealed() {
  if (now_ >= state().handover_until) name_next();
  if (state().mode != RoleMode::kSealed || now_ < state().next_send) return;
  state().next_send = now_ + Duration::from_s(settings_.heartbeat_s);
  send(std::nullopt, message(RoleOp::kSeal));
  if (!state().named) return;
  RoleMessage m = message(RoleOp::kHandover);
  m.term = state().handover_term;
  m.candidate = *state().named;
  send(state().named, std::move(m));
}

void RoleStepper::on(const RoleLink& event) {
  if (in_fleet(event.from) && event.from != state().self) state().link_received = now_;
}

void RoleStepper::on(const RoleSelf& event) {
  state().standing_since = event.standing_since;
  state().eligible = event.eligible;
  const bool moves = !event.standing_since;
  // Pushed, or driven by hand: its measurements as a reference are valid only up to here.
  if (moves && state().mode == RoleMode::kAnchor) return seal();
  if (moves && state().mode == RoleMode::kCandidate) {
    state().mode = RoleMode::kTag;
    state().renews = false;
    wait_for_anchor();
  }
  if (!state().stands_for || state().durable.anchor != state().stands_for) return;
  if (static_cast<double>(event.ranges_to_anchor) < settings_.ranges_to_leave) return;
  state().stands_for.reset();
  act(RoleActionKind::kMayLeave, state().self);
}

void RoleStepper::on(const RoleFinished& event) {
  if (state().finished == event.reason) return;
  state().finished = event.reason;
  if (state().mode != RoleMode::kTag || !state().durable.anchor || state().orphan) return;
  RoleMessage m = message(RoleOp::kFinished);
  m.reason = event.reason;
  send(state().durable.anchor, std::move(m));
}

void RoleStepper::on(const RoleClaim&) {
  const bool promised = now_ < state().promise_until && !state().seal_received;
  if (state().mode == RoleMode::kTag && !promised && stands() && in_fleet(state().self) &&
      state().durable.confirmed && state().eligible) {
    return stand_for(state().durable.term + 1, false);
  }
  act(RoleActionKind::kRefused, state().self);
}

void RoleStepper::on(const RoleEndRound&) {
  if (state().mode == RoleMode::kAnchor) seal();
}

void RoleStepper::on(const RoleChoice& event) {
  if (state().mode != RoleMode::kSealed) return;
  state().choice = event.ranked;
  if (!state().named) name_next();
}

void RoleStepper::on(const RoleFleet& event) {
  std::vector<VehicleId> fleet = event.fleet;
  std::sort(fleet.begin(), fleet.end());
  fleet.erase(std::unique(fleet.begin(), fleet.end()), fleet.end());
  const bool has_self = std::binary_search(fleet.begin(), fleet.end(), state().self);
  // The vote cast with the change must not break a promise to an anchor that still acts.
  const bool promised = state().mode == RoleMode::kTag && now_ < state().promise_until;
  const bool able = has_self && stands() && state().durable.confirmed && !promised;
  if (!able || fleet == state().durable.fleet) {
    return act(RoleActionKind::kRefused, state().self);
  }
  const bool renews = state().mode == RoleMode::kAnchor;
  state().durable.fleet = std::move(fleet);
  stand_for(state().durable.term + 1, renews);
}

void RoleStepper::on(const RoleConfirm&) {
  if (state().durable.confirmed) return;
  state().durable.confirmed = true;
  step_.save = true;
}

double RoleStepper::chance() const {
  const std::uint64_t seed =
      (state().durable.term * 4099 + state().attempts) * 65537 + state().self.value;
  return Rng(seed, "fleet.role").uniform();
}

bool RoleStepper::in_fleet(VehicleId vehicle) const {
  const auto& fleet = state().durable.fleet;
  return std::binary_search(fleet.begin(), fleet.end(), vehicle);
}

bool RoleStepper::stands() const {
  return state().standing_since &&
         now_ - *state().standing_since >= Duration::from_s(settings_.stand_s);
}

bool RoleStepper::may_stand_for_election() const {
  if (!stands() || !state().eligible) return false;
  if (!state().durable.confirmed || !in_fleet(state().self)) return false;
  if (quorum() == 1) return true;
  // Without any link the election would be lost and only raise the term.
  return state().link_received && now_ - *state().link_received <= lease() + lease();
}

bool RoleStepper::all_finished() const {
  bool any = false;
  for (const RolePeer& p : state().peers) {
    // A vehicle that does not answer is gone: the round ends without it (middleware 4.4).
    const bool present = p.echoed && now_ - p.received <= lease();
    if (present && p.finished == FinishReason::kNone) return false;
    any = any || present;
  }
  return any;
}

}  // namespace detail

RoleState start_role(VehicleId self, DurableRole durable, const RoleSettings& settings, Time now) {
  RoleState state;
  state.self = self;
  std::sort(durable.fleet.begin(), durable.fleet.end());
  state.durable = std::move(durable);
  state.orphan = true;
  const double rate = settings.clock_rate;
  const double promise_s = settings.lease_s * (1.0 + rate) / (1.0 - rate);
  state.promise_until = state.durable.term == 0 ? now : now + Duration::from_s(promise_s);
  const double chance = Rng(state.self.value, "fleet.role.start").uniform();
  state.takeover_at =
      now + Duration::from_s(settings.lease_s * (2.0 * (1.0 + settings.clock_rate) + chance));
  return state;
}

RoleStep role_step(const RoleState& state, const RoleSettings& settings, const RoleEvent& event,
                   Time now) {
  detail::RoleStepper stepper(state, settings, now);
  std::visit([&stepper](const auto& e) { stepper.on(e); }, event);
  return stepper.take();
}

bool may_publish(const RoleState& state, Time now) {
  return state.mode == RoleMode::kAnchor && now < state.lease_until;
}

bool must_stand(const RoleState& state) {
  return state.mode != RoleMode::kTag || state.orphan || state.seal_received ||
         state.finished != FinishReason::kNone || state.stands_for.has_value();
}

bool accept_table(RoleState& state, VehicleId from, std::uint64_t term, std::uint32_t revision) {
  if (term != state.durable.term || state.durable.anchor != from) return false;
  if (std::pair(term, revision) < std::pair(state.table_term, state.table_revision)) return false;
  state.table_term = term;
  state.table_revision = revision;
  return true;
}

}  // namespace rali::fleet
