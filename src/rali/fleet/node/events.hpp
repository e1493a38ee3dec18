#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/fleet/node/job.hpp"
#include "rali/fleet/roles/role_state.hpp"

namespace rali::fleet {

/// A fact of this vehicle's own.
struct OwnFact {
  std::shared_ptr<const Fact> fact;
};

/// Where this vehicle believes to be.
struct OwnPose {
  Time t;
  geometry::SE3 T_odom_body;
  bool at_rest = false;
  bool levelled = false;  ///< the direction of gravity is known
  bool blind = false;     ///< the LiDAR does not tell a direction of travel
  double sigma_m = 0.0;   ///< largest standard deviation of the place
  geometry::Vec3 blind_odom = geometry::Vec3::Zero();  ///< unit, where blind
};

/// A range to another vehicle that the radio's limits let pass.
struct HeardRange {
  VehicleId peer;
  double range_m = 0.0;
};

/// How strongly another vehicle was heard.
struct HeardRadio {
  VehicleId peer;
  double rssi_dbm = 0.0;
};

/// How the drive to the place of order `number` goes.
struct DriveStatus {
  std::uint64_t number = 0;
  DriveState state = DriveState::kStanding;
};

/// The log on the disk has kept what it was given.
struct Persisted {
  std::vector<FactKey> facts;     ///< synced since the last event
  std::uint64_t role = 0;         ///< number of the last SaveRole that is synced; 0: none yet
  std::uint64_t free_bytes = 0;   ///< that the disk still takes
  std::size_t failing_facts = 0;  ///< that could not be written and are tried again
};

/// These facts could not be written. They stay in memory and are tried again; until then nobody may
/// rely on this vehicle to keep them.
struct PersistFailed {
  std::vector<FactKey> facts;
  std::string why;
};

/// The operator confirms that no vote was given that the disk does not know (RoleConfirm).
struct ConfirmRole {};

/// An order of the operator, known to be his. What cannot be obeyed now is a Finding.
struct OperatorOrder {
  enum class Kind {
    kEndRound,    ///< the anchor seals now
    kAssumeLost,  ///< `vehicle` has no vote any more; he must not say it to two halves of a fleet
    kFinish       ///< the mission ends with this round's map
  };

  Kind kind = Kind::kEndRound;
  VehicleId vehicle;
};

/// Time passes: ten times a second is usual.
struct NodeTick {};

/// A job that was asked for has ended: it ran to its end, or was cancelled. Null: it is lost, and
/// what it was made from with it. An unknown number is ignored.
struct JobDone {
  std::uint64_t number = 0;
  std::shared_ptr<Job> job;
};

using NodeEvent = std::variant<OwnFact, OwnPose, HeardRange, HeardRadio, DriveStatus, Envelope,
                               Persisted, PersistFailed, ConfirmRole, OperatorOrder, NodeTick,
                               JobDone>;

/// To be synced to disk. Without a log, before any message that follows leaves; with one, the
/// messages that must wait for it come after Persisted::role has reached `number`.
struct SaveRole {
  DurableRole durable;
  std::uint64_t number = 0;
};

/// A fact, own or foreign, that the log does not have yet. Only with a log.
struct SaveFact {
  FactPtr fact;
};

/// To be run beside the steps. For each the host gives back one JobDone with the same number and
/// job, whenever run() has returned: in the order in which they end, as an event like any other.
struct RunJob {
  JobKind kind = JobKind::kEstimate;
  std::uint64_t number = 0;  ///< running number of this vehicle's jobs
  std::shared_ptr<Job> job;
};

/// The result of this job is not wanted any more: the host sets its flag. Its JobDone comes all the
/// same. An unknown number, or one that has ended, is ignored.
struct CancelJob {
  std::uint64_t number = 0;
};

using NodeOutput =
    std::variant<SaveRole, SaveFact, Envelope, RoleAction, Finding, RunJob, CancelJob>;
using NodeOutputs = std::vector<NodeOutput>;

/// What a node is built from when its program starts.
struct NodeStart {
  DurableRole durable;         ///< without a fleet: that of a newcomer
  std::uint32_t epoch = 0;     ///< of this start: above that of any fact sent before
  std::vector<FactPtr> facts;  ///< that the log holds
  /// There is a log: facts and roles count as kept when Persisted says so. Else at once.
  bool logs = false;
};

/// Where the vehicle is to go. Frame `map` is that of the fleet's largest group.
struct DriveOrder {
  std::uint64_t number = 0;                  ///< another one: the order has changed
  std::vector<geometry::Vec3> places_map_m;  ///< in order, at the height of bodies; empty: stand
};

}  // namespace rali::fleet
