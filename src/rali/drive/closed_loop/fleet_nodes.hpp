#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/closed_loop/simulated_jobs.hpp"
#include "rali/drive/closed_loop/step_times.hpp"
#include "rali/drive/link/loopback.hpp"
#include "rali/drive/state/state_dir.hpp"
#include "rali/factlog/memory_log.hpp"
#include "rali/fleet/node/node.hpp"
#include "rali/sim/fleet/closed_loop.hpp"

namespace rali::drive {

/// How a mission ended, as seen by the fleet software.
struct MissionLog {
  std::vector<fleet::RoundRow> rounds;        ///< each as recorded by its anchor
  std::vector<fleet::FrontierRow> frontiers;  ///< `round` refers to `rounds`
  bool explored = false;                      ///< no open frontier remained
  bool ended = false;                         ///< ended by the fleet itself
  std::uint64_t unreadable = 0;               ///< messages
  std::vector<fleet::TrafficCount> reported;  ///< sent by each vehicle; a broadcast counts once
};

struct FleetNodesSetup {
  std::vector<std::string> names;  ///< by number
  fleet::NodeSettings node;
  fleet::FleetKnowledge known;
  LinkSettings link;  ///< between any two; lossless by default
  ComputerSettings computer;
  JobCost job_cost;
  std::uint64_t seed = 1;
  /// Each vehicle keeps its facts and its role in a log in memory, and can be restarted. Each
  /// vehicle then encodes every fact, which costs time.
  bool logs = false;
  /// Sees each output of a node before it takes effect; may kill the vehicle, whose further outputs
  /// are then dropped.
  std::function<void(std::size_t index, const fleet::NodeOutput& output)> watch;
};

/// The fleet nodes of all vehicles in one process, a byte-level radio between them, and the
/// resulting drive commands. Jobs take the time that the vehicles' computers would need.
class FleetNodes {
 public:
  FleetNodes(const FleetNodesSetup& setup, Time begin);

  /// Sets the current time: messages are sent with it.
  void advance(Time now) { now_ = std::max(now_, now); }

  /// Passes a measurement or result to the vehicle's node. Dead vehicles receive nothing.
  void report(std::size_t index, const fleet::NodeEvent& event, Time t, Executor& executor);

  /// Broadcasts a vehicle's peer state to all others by radio. Dead vehicles send nothing.
  void report(std::size_t index, const fleet::PeerStatus& status);

  struct ReceivedStatus {
    std::size_t to = 0;
    fleet::PeerStatus status;
  };

  /// Peer states that arrived since the last call; the odometry takes them.
  [[nodiscard]] std::vector<ReceivedStatus> take_received() { return std::exchange(received_, {}); }

  /// Delivers finished jobs and messages, reports drive status and time to all nodes, and returns
  /// the changes of their drive orders.
  [[nodiscard]] std::vector<sim::DriveCommand> decide(Time now,
                                                      std::span<const sim::DriveReport> vehicles,
                                                      Executor& executor);

  /// Ends the vehicle's process: it computes, receives and sends nothing more, and its drive stops.
  /// What its log has not synced is lost.
  void kill(std::size_t index);

  /// Restarts a killed vehicle from its log, in its next epoch. Errors: kUsage for a vehicle that
  /// is alive or has no log; those of StateDir::restore.
  [[nodiscard]] Status restart(std::size_t index);

  [[nodiscard]] bool alive(std::size_t index) const { return members_[index].alive; }

  /// All vehicles that are alive report the mission as over.
  [[nodiscard]] bool finished() const;

  [[nodiscard]] MissionLog log() const;

  /// Times of the nodes' steps so far.
  [[nodiscard]] const StepTimes& step_times() const { return step_times_; }

  [[nodiscard]] const SimulatedJobs& jobs() const { return jobs_; }

  /// Findings of the nodes so far, each with its vehicle's name.
  [[nodiscard]] FindingList take_findings() { return std::exchange(findings_, {}); }

  [[nodiscard]] const fleet::Node& node(std::size_t index) const { return *members_[index].node; }

  [[nodiscard]] const std::string& name(std::size_t index) const { return members_[index].name; }

  [[nodiscard]] std::size_t size() const { return members_.size(); }

  [[nodiscard]] Loopback& radio() { return link_; }

  [[nodiscard]] const Loopback& radio() const { return link_; }

 private:
  /// What outlives a process.
  struct Disk {
    std::shared_ptr<factlog::MemoryLog> log = std::make_shared<factlog::MemoryLog>();
    std::shared_ptr<factlog::MemorySlots> slots = std::make_shared<factlog::MemorySlots>();
  };

  struct Member {
    std::string name;
    Disk disk;
    std::optional<StateDir> state;          ///< set if logs are kept
    std::vector<fleet::RoundMachine> past;  ///< of the nodes before the last restart
    std::unique_ptr<fleet::Node> node;
    bool alive = true;
    bool stopped = false;      ///< dead, and the stop command was given
    std::uint64_t obeyed = 0;  ///< number of the last order that became a command
    std::uint64_t goals = 0;   ///< of the driver, when that command was given
  };

  [[nodiscard]] Status start(std::size_t index);
  void step(std::size_t index, const fleet::NodeEvent& event, Time t, Executor& executor);
  void obey(std::size_t index, const fleet::NodeOutput& output, Time t, Executor& executor);
  void note(const Member& member, Finding finding);
  void send(const Member& member, const fleet::Envelope& envelope);
  void collect_jobs(Executor& executor);
  void collect_mail(Executor& executor);
  void report_drive(std::size_t index, const sim::DriveReport& drive, Executor& executor);
  [[nodiscard]] std::optional<sim::DriveCommand> command(std::size_t index);

  FleetNodesSetup setup_;
  std::vector<VehicleId> ids_;
  Loopback link_;
  SimulatedJobs jobs_;
  StepTimes step_times_;
  std::vector<Member> members_;
  fleet::NodeOutputs outputs_;
  FindingList findings_;
  std::vector<ReceivedStatus> received_;
  Time now_;  ///< of the last decision; the radio's clock
  std::uint64_t unreadable_ = 0;
};

}  // namespace rali::drive
