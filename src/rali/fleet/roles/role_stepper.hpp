#pragma once

#include "rali/fleet/roles/role_machine.hpp"

namespace rali::fleet::detail {

/// One running step: the state being changed, and its outputs. Only for the sources of the role
/// machine.
class RoleStepper {
 public:
  RoleStepper(const RoleState& state, const RoleSettings& settings, Time now)
      : settings_(settings), now_(now) {
    step_.state = state;
  }

  void on(const RoleTick& event);
  void on(const RoleReceived& event);
  void on(const RoleLink& event);
  void on(const RoleSelf& event);
  void on(const RoleFinished& event);
  void on(const RoleClaim& event);
  void on(const RoleEndRound& event);
  void on(const RoleChoice& event);
  void on(const RoleFleet& event);
  void on(const RoleConfirm& event);

  [[nodiscard]] RoleStep take() { return std::move(step_); }

 private:
  // Effects of time (role_machine.cpp).
  void tick_tag();
  void tick_candidate();
  void tick_anchor();
  void tick_sealed();

  // Messages (role_messages.cpp).
  void receive_anchor(VehicleId from, const RoleMessage& m);
  void receive_seal(VehicleId from, const RoleMessage& m);
  void receive_ack(VehicleId from, const RoleMessage& m);
  void receive_finished(VehicleId from, const RoleMessage& m);
  void receive_handover(VehicleId from, const RoleMessage& m);
  void receive_propose(VehicleId from, const RoleMessage& m);
  void receive_grant(VehicleId from, const RoleMessage& m);
  void receive_refuse(VehicleId from, const RoleMessage& m);
  void follow(VehicleId anchor, std::uint64_t term);
  void grant(VehicleId candidate, std::uint64_t term);
  [[nodiscard]] bool may_grant(VehicleId candidate) const;

  // Changes of mode (role_changes.cpp).
  void stand_for(std::uint64_t term, bool renews);
  void commit_if_majority();
  void seal();
  void step_down();
  void name_next();
  void reset_peers();
  void renew_lease();
  void wait_for_anchor();

  void send(std::optional<VehicleId> to, RoleMessage message);
  void send_propose();
  void act(RoleActionKind kind, VehicleId vehicle);
  [[nodiscard]] RoleMessage message(RoleOp op) const;
  [[nodiscard]] RolePeer* peer(VehicleId vehicle);
  [[nodiscard]] bool in_fleet(VehicleId vehicle) const;
  [[nodiscard]] bool all_finished() const;
  [[nodiscard]] bool stands() const;
  [[nodiscard]] bool may_stand_for_election() const;

  [[nodiscard]] std::size_t quorum() const { return quorum_of(state().durable.fleet.size()); }

  /// Uniform in [0, 1), the same for the same vehicle, term and attempt.
  [[nodiscard]] double chance() const;

  [[nodiscard]] Duration lease() const { return Duration::from_s(settings_.lease_s); }

  /// Longest remaining lease of another after a promise, on this clock: its clock may be slow, this
  /// one fast.
  [[nodiscard]] Duration promise() const {
    const double rate = settings_.clock_rate;
    return Duration::from_s(settings_.lease_s * (1.0 + rate) / (1.0 - rate));
  }

  [[nodiscard]] RoleState& state() { return step_.state; }

  [[nodiscard]] const RoleState& state() const { return step_.state; }

  const RoleSettings& settings_;
  Time now_;
  RoleStep step_;
};

}  // namespace rali::fleet::detail
