#pragma once

#include "rali/fleet/roles/role_state.hpp"

namespace rali::fleet {

/// State at the start of the program, from the contents of the disk. Earlier promises are not on
/// disk, so it grants no vote for as long as one could last. Term 0 is exempt, because no promise
/// existed. An unreadable disk is `durable.confirmed = false`.
[[nodiscard]] RoleState start_role(VehicleId self, DurableRole durable,
                                   const RoleSettings& settings, Time now);

/// The role machine: selects the anchor (algorithms_fleet 10.5, middleware 4.3). A pure function:
/// same arguments, same result; `now` is the vehicle's own clock, of which only the rate is
/// trusted. If `save` is set, the caller syncs `state.durable` before it sends the messages.
///
/// Invariants for any loss, delay, repetition and order of messages, and restarts at any point:
/// I1 at most one committed anchor per term, and at one time at most one that acts (may_publish);
/// I2 terms of a vehicle never decrease; I3 only a committed anchor acts in its term; I6 an anchor
/// is at standstill from commit to seal; I7 a vehicle follows the highest committed term received.
[[nodiscard]] RoleStep role_step(const RoleState& state, const RoleSettings& settings,
                                 const RoleEvent& event, Time now);

/// Anchor within its lease: may make tables.
[[nodiscard]] bool may_publish(const RoleState& state, Time now);

/// The vehicle must not move now: anchor, about to become one, or without any; or an old anchor
/// that the new one still needs; or a tag that has finished. A moving tag completes its move first.
[[nodiscard]] bool must_stand(const RoleState& state);

/// I4: whether a part of a table of (term, revision) from this vehicle is accepted; records it.
/// Refuses tables older than the last accepted one and those not from the anchor of the term.
[[nodiscard]] bool accept_table(RoleState& state, VehicleId from, std::uint64_t term,
                                std::uint32_t revision);

/// Votes that make a majority of a fleet of this size.
[[nodiscard]] constexpr std::size_t quorum_of(std::size_t fleet_size) { return fleet_size / 2 + 1; }

}  // namespace rali::fleet
