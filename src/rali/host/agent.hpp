#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "rali/fleet/node/node.hpp"
#include "rali/host/goal_watch.hpp"
#include "rali/net/fleet_link.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::host {

/// Bytes for other vehicles of the fleet.
struct SendBytes {
  std::optional<VehicleId> to;  ///< none: all
  net::Urgency urgency = net::Urgency::kBulk;
  wire::Bytes bytes;
};

/// A peer state reported by another vehicle, for the odometry.
struct PeerReport {
  fleet::PeerStatus status;
};

using AgentOutput = std::variant<SendBytes, PeerReport, fleet::SaveRole, fleet::SaveFact,
                                 fleet::RunJob, fleet::CancelJob, fleet::RoleAction, Finding>;
using AgentOutputs = std::vector<AgentOutput>;

struct AgentSetup {
  VehicleId self;
  std::vector<std::string> names;  ///< of all vehicles, by number
  fleet::NodeSettings node;
  fleet::FleetKnowledge known;
  fleet::NodeStart start;  ///< restored from the disk
};

/// The last status received from another vehicle.
struct ReceivedVehicle {
  fleet::VehicleStatus status;
  Time t;  ///< of arrival, on the agent's clock
};

/// Counts of rejected messages.
struct AgentTally {
  std::uint64_t unreadable = 0;  ///< damaged, or of a newer program
  std::uint64_t wrong_sender = 0;
};

/// One vehicle's part in its fleet: passes odometry outputs to its node, and encodes the node's
/// messages for the others. The same connections as in simulation, without thread, clock or socket.
///
/// Its clock starts at the time of the sensor stamps and advances with the time since the machine
/// started: the node compares it with stamps, and leases depend on its rate only.
class Agent {
 public:
  Agent(const AgentSetup& setup, Time now);

  /// Takes an output of the vehicle.
  void take(const vehicle::Output& output, Time now, AgentOutputs& out);

  /// A range that was passed to the vehicle.
  void take(const sensor::RangeSample& range, Time now, AgentOutputs& out);

  void take(const sensor::RadioSample& radio, Time now, AgentOutputs& out);

  /// Goal status from the navigation.
  void take(const wire::GoalStatusArray& status) { goal_watch_.received(status); }

  /// Bytes from the verified sender `from`.
  void receive(VehicleId from, std::span<const std::byte> bytes, Time now, AgentOutputs& out);

  /// What the log on disk has kept, or could not keep.
  void take(const fleet::Persisted& event, Time now, AgentOutputs& out) { step(event, now, out); }

  void take(const fleet::PersistFailed& event, Time now, AgentOutputs& out) {
    step(event, now, out);
  }

  /// A job has ended.
  void take(const fleet::JobDone& done, Time now, AgentOutputs& out) { step(done, now, out); }

  /// A command of the operator.
  void take(const fleet::OperatorOrder& order, Time now, AgentOutputs& out) {
    step(order, now, out);
  }

  /// Advances the time; called ten times a second.
  void tick(Time now, AgentOutputs& out);

  [[nodiscard]] const fleet::Node& node() const { return node_; }

  [[nodiscard]] VehicleId self() const { return self_; }

  /// The newest pose of the vehicle's own odometry.
  [[nodiscard]] const std::optional<vehicle::PoseEstimate>& pose() const { return pose_; }

  [[nodiscard]] const std::map<VehicleId, ReceivedVehicle>& received() const { return received_; }

  /// Frontiers and goal assignments, as last reported by the anchor.
  [[nodiscard]] const std::optional<fleet::GoalList>& goals() const { return goals_; }

  /// The anchor of the round, as far as this vehicle knows.
  [[nodiscard]] std::optional<VehicleId> anchor() const { return node_.rounds().anchor(); }

  [[nodiscard]] const AgentTally& tally() const { return tally_; }

 private:
  void step(const fleet::NodeEvent& event, Time now, AgentOutputs& out);
  void pass_on(const fleet::Envelope& envelope, AgentOutputs& out);
  void note(const fleet::Message& message, VehicleId from, Time now);
  [[nodiscard]] fleet::DriveStatus drive_status() const;

  VehicleId self_;
  std::vector<std::string> names_;
  double arrive_m_;
  fleet::Node node_;
  fleet::NodeOutputs node_out_;
  bool levelled_ = false;
  std::optional<vehicle::PoseEstimate> pose_;
  std::map<VehicleId, ReceivedVehicle> received_;
  std::optional<fleet::GoalList> goals_;
  GoalWatch goal_watch_;
  AgentTally tally_;
};

}  // namespace rali::host
