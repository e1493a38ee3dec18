#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/fleet/messages/messages.hpp"

namespace rali::fleet {

/// Times and guards of the role machine (algorithms_fleet 10.5, middleware 4.3).
struct RoleSettings {
  double lease_s = 5.0;           ///< L: an anchor acts this long after a majority has answered
  double heartbeat_s = 1.0;       ///< also the repetition period of unanswered messages
  double clock_rate = 0.02;       ///< clocks may run this much fast or slow
  double stand_s = 3.0;           ///< standstill of a vehicle before it becomes anchor
  double ranges_to_leave = 10.0;  ///< an old anchor waits for as many ranges to the new one ...
  double leave_s = 30.0;          ///< ... but not longer than this
  double round_timeout_s = 900.0;

  template <class V>
  void visit(V& v) {
    v("lease_s", lease_s, 0.0, 600.0, "an anchor acts this long after a majority's answer [s]");
    v("heartbeat_s", heartbeat_s, 0.0, 60.0, "time between heartbeats of the anchor [s]");
    v("clock_rate", clock_rate, 0.0, 0.2, "largest rate error of a clock, as a fraction");
    v("standstill_s", stand_s, 0.0, 60.0, "standstill of a vehicle before it becomes anchor [s]");
    v("ranges_to_leave", ranges_to_leave, 0.0, 1000.0, "ranges to the new anchor first");
    v("leave_s", leave_s, 0.0, 600.0, "longest wait of the old anchor for them [s]");
    v("round_timeout_s", round_timeout_s, 1.0, 1e5, "a round ends after this long [s]");
  }
};

/// State that must be on disk before an answer is sent: a forgotten vote could be cast twice.
struct DurableRole {
  std::uint64_t term = 0;
  std::optional<VehicleId> granted_to;  ///< who has this vehicle's vote in `term`
  std::optional<VehicleId> anchor;      ///< committed in `term`, as far as received
  std::vector<VehicleId> fleet;         ///< ascending; votes count against all of it
  /// False: the disk was unreadable, so votes may be forgotten; grants nothing and asks for no
  /// votes until an operator confirms.
  bool confirmed = true;

  bool operator==(const DurableRole&) const = default;
};

enum class RoleMode : std::uint8_t { kTag, kCandidate, kAnchor, kSealed };

/// State of another vehicle as anchor or candidate tracks it, in its own term.
struct RolePeer {
  VehicleId vehicle;
  bool granted = false;
  std::optional<Time> echoed;  ///< own clock: latest own message that it has answered
  Time received;               ///< own clock: when that answer arrived
  FinishReason finished = FinishReason::kNone;
  Time finished_sent;  ///< its clock: identifies the newer of two reordered messages
};

/// Complete state of the machine. Only `durable` survives a restart.
struct RoleState {
  VehicleId self;
  DurableRole durable;
  RoleMode mode = RoleMode::kTag;
  bool orphan = false;  ///< no anchor with a majority: keeps standstill, makes no tables
  FinishReason finished = FinishReason::kNone;
  std::optional<Time> standing_since;
  bool eligible = true;  ///< may become anchor: its disk can store an anchor's data

  /// Until this time it votes only for the vehicle with its promise: that lease may last.
  Time promise_until;
  bool seal_received = false;         ///< the anchor of `durable.term` has ended its round
  std::optional<VehicleId> followed;  ///< anchor of the current round
  Time takeover_at;                   ///< becomes candidate if no anchor message arrives until then
  std::optional<Time> link_received;
  Time next_send;
  std::uint32_t attempts = 0;  ///< consecutive lost elections

  std::vector<RolePeer> peers;  ///< of the fleet without self, ascending; candidate and anchor
  Time candidate_until;
  Time anchor_since;
  bool renews = false;  ///< candidate: was the anchor until now, the round continues
  Time lease_until;     ///< anchor: acts only before this time

  std::vector<VehicleId> choice;  ///< sealed: next anchors, best first
  std::vector<VehicleId> tried;   ///< sealed: already named
  std::optional<VehicleId> named;
  std::uint64_t handover_term = 0;
  Time handover_until;

  std::optional<VehicleId> stands_for;  ///< was anchor: keeps standstill until this one is
                                        ///< connected
  Time stands_until;

  std::uint64_t table_term = 0;  ///< of the last table accepted
  std::uint32_t table_revision = 0;
};

// Events.

/// Time passes. Any period is possible; 0.1 to 0.5 s is usual.
struct RoleTick {};

struct RoleReceived {
  VehicleId from;
  RoleMessage message;
};

/// A message of another kind arrived from this vehicle: there is a link.
struct RoleLink {
  VehicleId from;
};

/// State of the own vehicle.
struct RoleSelf {
  std::optional<Time> standing_since;  ///< none: is moving
  std::uint32_t ranges_to_anchor = 0;  ///< accepted since the current anchor was committed
  bool eligible = true;                ///< false: is not a candidate for anchor
};

/// A condition of algorithms_fleet 10.1 is met; kNone: no longer.
struct RoleFinished {
  FinishReason reason = FinishReason::kNone;
};

/// Become candidate now: first anchor of a mission.
struct RoleClaim {};

/// The centre or the operator ends the round.
struct RoleEndRound {};

/// Answer to RoleActionKind::kSealed, may be repeated with newer data: next anchors, best first,
/// only those that hold what the seal's inventory names.
struct RoleChoice {
  std::vector<VehicleId> ranked;
};

/// The operator's order that replaces the votes of lost vehicles (`--assume-lost`), or takes one
/// back. It must not be given in two parts of a split fleet.
struct RoleFleet {
  std::vector<VehicleId> fleet;
};

/// The operator confirms that no vote was cast that is not on the disk.
struct RoleConfirm {};

using RoleEvent = std::variant<RoleTick, RoleReceived, RoleLink, RoleSelf, RoleFinished, RoleClaim,
                               RoleEndRound, RoleChoice, RoleFleet, RoleConfirm>;

// Answers.

struct RoleSend {
  std::optional<VehicleId> to;  ///< none: all
  /// `number`, `revision`, and for kFinished and kSeal `inventory` and `T_odom_body`, are filled in
  /// by the caller: the machine neither counts messages nor stores facts.
  RoleMessage message;
};

enum class RoleActionKind : std::uint8_t {
  kBecameAnchor,      ///< publish tables of this term, revision 0 first; keep standstill
  kRenewedTerm,       ///< the same, but the round continues: only the term is new
  kStoppedAnchoring,  ///< publish nothing more
  kFollows,           ///< a new anchor: a new round
  kSealed,            ///< send the last table, then answer with RoleChoice
  kOrphaned,          ///< complete the move, keep standstill, keep recording
  kRejoined,          ///< messages of an anchor arrive again
  kMayLeave,          ///< the new anchor is connected: the old one is a tag that may move
  kNotInFleet,        ///< the anchor does not list this vehicle in the fleet any more
  kConflict,          ///< two anchors of one term: a vehicle broke a promise
  kRefused            ///< an operator's command that cannot be executed now
};

struct RoleAction {
  RoleActionKind kind = RoleActionKind::kFollows;
  std::uint64_t term = 0;
  VehicleId vehicle;  ///< whom it concerns
};

struct RoleStep {
  RoleState state;
  bool save = false;  ///< state.durable must be synced to disk before any message is sent
  std::vector<RoleSend> messages;
  std::vector<RoleAction> actions;
};

}  // namespace rali::fleet
