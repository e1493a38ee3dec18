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

/// Estimated pose of this vehicle.
struct OwnPose {
  Time t;
  geometry::SE3 T_odom_body;
  bool at_rest = false;
  bool levelled = false;    ///< the direction of gravity is known
  bool degenerate = false;  ///< a direction of travel is unobservable to the LiDAR
  double sigma_m = 0.0;     ///< largest standard deviation of the position
  geometry::Vec3 degenerate_odom = geometry::Vec3::Zero();  ///< unit, where degenerate
};

/// A range to another vehicle that passed the radio's limits.
struct ReceivedRange {
  VehicleId peer;
  double range_m = 0.0;
};

/// Received signal strength of another vehicle.
struct ReceivedRadio {
  VehicleId peer;
  double rssi_dbm = 0.0;
};

/// State of the drive to the goal of order `number`.
struct DriveStatus {
  std::uint64_t number = 0;
  DriveState state = DriveState::kStanding;
};

/// Progress of the log on the disk.
struct Persisted {
  std::vector<FactKey> facts;     ///< synced since the last event
  std::uint64_t role = 0;         ///< number of the last SaveRole that is synced; 0: none yet
  std::uint64_t free_bytes = 0;   ///< space left on the disk
  std::size_t failing_facts = 0;  ///< that could not be written and are retried
};

/// These facts could not be written. They stay in memory and are retried; until then nobody may
/// rely on this vehicle to keep them.
struct PersistFailed {
  std::vector<FactKey> facts;
  std::string why;
};

/// The operator confirms that no vote was cast that is not on the disk (RoleConfirm).
struct ConfirmRole {};

/// An authenticated order of the operator. An order that cannot be obeyed now becomes a Finding.
struct OperatorOrder {
  enum class Kind {
    kEndRound,    ///< the anchor seals now
    kAssumeLost,  ///< `vehicle` has no vote any more; must not be ordered in two parts of a split
                  ///< fleet
    kFinish       ///< the mission ends with this round's map
  };

  Kind kind = Kind::kEndRound;
  VehicleId vehicle;
};

/// Time passes: usually sent ten times a second.
struct NodeTick {};

/// A requested job has ended: it was completed or cancelled. Null: the job is lost together with
/// its inputs. An unknown number is ignored.
struct JobDone {
  std::uint64_t number = 0;
  std::shared_ptr<Job> job;
};

using NodeEvent =
    std::variant<OwnFact, OwnPose, ReceivedRange, ReceivedRadio, DriveStatus, Envelope, Persisted,
                 PersistFailed, ConfirmRole, OperatorOrder, NodeTick, JobDone>;

/// To be synced to disk. Without a log: before any later message is sent. With a log, the messages
/// that depend on it are output after Persisted::role has reached `number`.
struct SaveRole {
  DurableRole durable;
  std::uint64_t number = 0;
};

/// A fact, own or foreign, that the log does not have yet. Only with a log.
struct SaveFact {
  FactPtr fact;
};

/// To be run beside the steps. For each job the host returns one JobDone with the same number and
/// job after run() has returned: in order of completion, as an event like any other.
struct RunJob {
  JobKind kind = JobKind::kEstimate;
  std::uint64_t number = 0;  ///< running number of this vehicle's jobs
  std::shared_ptr<Job> job;
};

/// The result of this job is not wanted any more: the host sets its flag. Its JobDone still
/// follows. An unknown number, or one that has ended, is ignored.
struct CancelJob {
  std::uint64_t number = 0;
};

using NodeOutput =
    std::variant<SaveRole, SaveFact, Envelope, RoleAction, Finding, RunJob, CancelJob>;
using NodeOutputs = std::vector<NodeOutput>;

/// Input of a node when its program starts.
struct NodeStart {
  DurableRole durable;         ///< without a fleet: that of a vehicle that joins
  std::uint32_t epoch = 0;     ///< of this start: above that of any fact sent before
  std::vector<FactPtr> facts;  ///< contents of the log
  /// There is a log: facts and roles count as stored when Persisted reports it. Else at once.
  bool logs = false;
};

/// Goal of the vehicle. Frame `map` is that of the fleet's largest group.
struct DriveOrder {
  std::uint64_t number = 0;                  ///< a different number: the order has changed
  std::vector<geometry::Vec3> places_map_m;  ///< in order, at the height of bodies; empty: stop
};

}  // namespace rali::fleet
