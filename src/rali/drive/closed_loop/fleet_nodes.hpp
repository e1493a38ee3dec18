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

/// How a mission ended, as the fleet's software sees it.
struct MissionLog {
  std::vector<fleet::RoundRow> rounds;        ///< each as its anchor had it
  std::vector<fleet::FrontierRow> frontiers;  ///< `round` is that of `rounds`
  bool explored = false;                      ///< no open frontier was left
  bool ended = false;                         ///< by the fleet itself
  std::uint64_t unreadable = 0;               ///< messages
  std::vector<fleet::TrafficCount> said;      ///< by each vehicle, once however many hear it
};

struct FleetNodesSetup {
  std::vector<std::string> names;  ///< by number
  fleet::NodeSettings node;
  fleet::FleetKnowledge known;
  LinkSettings link;  ///< between any two; lossless unless told otherwise
  ComputerSettings computer;
  JobCost job_cost;
  std::uint64_t seed = 1;
  /// Each vehicle keeps its facts and its role in a log in memory, and can be restarted. Costs the
  /// encoding of each fact at each vehicle.
  bool logs = false;
  /// Sees what a node gives before it is obeyed; may kill the vehicle, which then obeys no more.
  std::function<void(std::size_t index, const fleet::NodeOutput& output)> watch;
};

/// The parts that vehicles of one process play in their fleet, a radio of bytes between them, and
/// the drivers' commands that come of it. Their jobs take the time that the vehicles' computers
/// would need.
class FleetNodes {
 public:
  FleetNodes(const FleetNodesSetup& setup, Time begin);

  /// It is this late now: what is said is sent at this time.
  void advance(Time now) { now_ = std::max(now_, now); }

  /// What a vehicle has measured or made. Nothing reaches one that is dead.
  void tell(std::size_t index, const fleet::NodeEvent& event, Time t, Executor& executor);

  /// What a vehicle says of itself to all others, over the radio. Nothing from one that is dead.
  void say(std::size_t index, const fleet::PeerStatus& status);

  struct HeardStatus {
    std::size_t to = 0;
    fleet::PeerStatus status;
  };

  /// What arrived since the last call of what others said of themselves: it is for the odometry.
  [[nodiscard]] std::vector<HeardStatus> take_heard() { return std::exchange(heard_, {}); }

  /// Brings jobs that have ended and the mail, tells all how their drives go and what time it is,
  /// and returns what changed in where they are to go.
  [[nodiscard]] std::vector<sim::DriveCommand> decide(Time now,
                                                      std::span<const sim::DriveReport> vehicles,
                                                      Executor& executor);

  /// Its process is gone: it does, hears and says nothing more, and its drive stops. What its log
  /// had not synced is lost.
  void kill(std::size_t index);

  /// A vehicle that was killed starts again from its log, in its next epoch. Errors: kUsage for one
  /// that is alive or has no log; those of StateDir::restore.
  [[nodiscard]] Status restart(std::size_t index);

  [[nodiscard]] bool alive(std::size_t index) const { return members_[index].alive; }

  /// All who are alive say that the mission is over.
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
  /// What is left when a process is gone.
  struct Disk {
    std::shared_ptr<factlog::MemoryLog> log = std::make_shared<factlog::MemoryLog>();
    std::shared_ptr<factlog::MemorySlots> slots = std::make_shared<factlog::MemorySlots>();
  };

  struct Member {
    std::string name;
    Disk disk;
    std::optional<StateDir> state;          ///< with a log
    std::vector<fleet::RoundMachine> past;  ///< of the nodes before the last restart
    std::unique_ptr<fleet::Node> node;
    bool alive = true;
    bool stopped = false;      ///< dead, and its driver was told
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
  void tell_drive(std::size_t index, const sim::DriveReport& report, Executor& executor);
  [[nodiscard]] std::optional<sim::DriveCommand> command(std::size_t index);

  FleetNodesSetup setup_;
  std::vector<VehicleId> ids_;
  Loopback link_;
  SimulatedJobs jobs_;
  StepTimes step_times_;
  std::vector<Member> members_;
  fleet::NodeOutputs outputs_;
  FindingList findings_;
  std::vector<HeardStatus> heard_;
  Time now_;  ///< of the last decision: the radio's clock
  std::uint64_t unreadable_ = 0;
};

}  // namespace rali::drive
