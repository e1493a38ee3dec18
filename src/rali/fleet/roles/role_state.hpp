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
  double lease_s = 5.0;           ///< L: an anchor acts this long on the answers of a majority
  double heartbeat_s = 1.0;       ///< also the repetition of all that waits for an answer
  double clock_rate = 0.02;       ///< clocks may run this much fast or slow
  double stand_s = 3.0;           ///< who becomes anchor has stood this long
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

/// What must be on disk before an answer leaves: a vote that is forgotten can be given twice.
struct DurableRole {
  std::uint64_t term = 0;
  std::optional<VehicleId> granted_to;  ///< who has this vehicle's vote in `term`
  std::optional<VehicleId> anchor;      ///< committed in `term`, as far as heard
  std::vector<VehicleId> fleet;         ///< ascending; votes count against all of it
  /// False: the disk was unreadable, so votes may be forgotten; grants and asks for nothing until
  /// an operator confirms.
  bool confirmed = true;

  bool operator==(const DurableRole&) const = default;
};

enum class RoleMode : std::uint8_t { kTag, kCandidate, kAnchor, kSealed };

/// What an anchor or candidate knows of another vehicle, in its own term.
struct RolePeer {
  VehicleId vehicle;
  bool granted = false;
  std::optional<Time> echoed;  ///< own clock: the latest of our messages that it has answered
  Time heard;                  ///< own clock: when that answer came
  FinishReason finished = FinishReason::kNone;
  Time finished_sent;  ///< its clock: younger of two messages that overtook each other
};

/// All that the machine remembers. Only `durable` survives a restart.
struct RoleState {
  VehicleId self;
  DurableRole durable;
  RoleMode mode = RoleMode::kTag;
  bool orphan = false;  ///< no anchor with a majority: stands, makes no tables
  FinishReason finished = FinishReason::kNone;
  std::optional<Time> standing_since;
  bool eligible = true;  ///< may become anchor: its disk keeps what an anchor is given

  /// Before this time no vote for anyone but the promised one: his lease may last.
  Time promise_until;
  bool seal_heard = false;            ///< the anchor of `durable.term` has ended its round
  std::optional<VehicleId> followed;  ///< anchor of the round that goes on
  Time takeover_at;                   ///< stands for election if nothing is heard until then
  std::optional<Time> link_heard;
  Time next_send;
  std::uint32_t attempts = 0;  ///< elections lost in a row

  std::vector<RolePeer> peers;  ///< of the fleet but self, ascending; candidate and anchor
  Time candidate_until;
  Time anchor_since;
  bool renews = false;  ///< candidate: was the anchor until now, the round goes on
  Time lease_until;     ///< anchor: acts before this time only

  std::vector<VehicleId> choice;  ///< sealed: next anchors, best first
  std::vector<VehicleId> tried;   ///< sealed: named already
  std::optional<VehicleId> named;
  std::uint64_t handover_term = 0;
  Time handover_until;

  std::optional<VehicleId> stands_for;  ///< was anchor: keeps standing until this one is tied in
  Time stands_until;

  std::uint64_t table_term = 0;  ///< of the last table accepted
  std::uint32_t table_revision = 0;
};

// Events.

/// Time passes. Any period will do; 0.1 to 0.5 s is usual.
struct RoleTick {};

struct RoleHeard {
  VehicleId from;
  RoleMessage message;
};

/// A message of another kind came from this vehicle: there is a link.
struct RoleLink {
  VehicleId from;
};

/// What the vehicle knows of itself.
struct RoleSelf {
  std::optional<Time> standing_since;  ///< none: moves
  std::uint32_t ranges_to_anchor = 0;  ///< accepted since the present anchor was committed
  bool eligible = true;                ///< false: is no candidate for anchor
};

/// A condition of algorithms_fleet 10.1 has come up; kNone: it has cleared.
struct RoleFinished {
  FinishReason reason = FinishReason::kNone;
};

/// Stand for election now: first anchor of a mission.
struct RoleClaim {};

/// The centre or the operator ends the round.
struct RoleEndRound {};

/// Answer to RoleActionKind::kSealed, may be repeated with newer knowledge: next anchors, best
/// first, only those that hold what the seal's inventory names.
struct RoleChoice {
  std::vector<VehicleId> ranked;
};

/// The operator's word that replaces the votes of vehicles that are lost (`--assume-lost`), or
/// takes one back. He must not say it to two halves of a fleet.
struct RoleFleet {
  std::vector<VehicleId> fleet;
};

/// The operator confirms that no vote was given that the disk does not know.
struct RoleConfirm {};

using RoleEvent = std::variant<RoleTick, RoleHeard, RoleLink, RoleSelf, RoleFinished, RoleClaim,
                               RoleEndRound, RoleChoice, RoleFleet, RoleConfirm>;

// Answers.

struct RoleSend {
  std::optional<VehicleId> to;  ///< none: all
  /// `number`, `revision`, and of kFinished and kSeal `inventory` and `T_odom_body`, are for the
  /// caller to fill in: the machine neither counts messages nor knows facts.
  RoleMessage message;
};

enum class RoleActionKind : std::uint8_t {
  kBecameAnchor,      ///< publish tables of this term, revision 0 first; stand
  kRenewedTerm,       ///< the same, but the round goes on: only the term is new
  kStoppedAnchoring,  ///< publish nothing more
  kFollows,           ///< a new anchor: a new round
  kSealed,            ///< last table, then RoleChoice is wanted
  kOrphaned,          ///< end the move, stand, keep recording
  kRejoined,          ///< an anchor is heard again
  kMayLeave,          ///< the new anchor is tied in: was anchor, is a tag that may move
  kNotInFleet,        ///< the anchor does not count on this vehicle any more
  kConflict,          ///< two anchors of one term: somebody broke a promise
  kRefused            ///< an operator's command that cannot be followed now
};

struct RoleAction {
  RoleActionKind kind = RoleActionKind::kFollows;
  std::uint64_t term = 0;
  VehicleId vehicle;  ///< whom it concerns
};

struct RoleStep {
  RoleState state;
  bool save = false;  ///< state.durable must be synced to disk before any message leaves
  std::vector<RoleSend> messages;
  std::vector<RoleAction> actions;
};

}  // namespace rali::fleet
