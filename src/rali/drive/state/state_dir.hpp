#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/factlog/disk_log.hpp"
#include "rali/factlog/role_slots.hpp"
#include "rali/fleet/node/events.hpp"

namespace rali::drive {

struct StateSettings {
  double sync_s = 0.5;          ///< facts are synced after this long ...
  std::size_t sync_facts = 64;  ///< ... or when so many wait
  double retry_s = 5.0;         ///< between two attempts after a failed write
  std::uint64_t reserve_bytes = std::uint64_t{64} << 20;  ///< for ranges and increments
  factlog::DiskLogSettings log;
};

/// A vehicle's persistent fleet state on disk (docs/reference/state.md): log of facts, role, epoch.
/// A host passes it the outputs SaveFact and SaveRole of its fleet::Node, calls sync(), and passes
/// the resulting events back to the node:
///
///     auto state = StateDir::open(folder, self, fleet);
///     fleet::Node node(self, fleet, settings, known, now, state->take_start());
///     // the vehicle's software: VehicleSettings::facts.epoch = state->epoch()
///     ...
///     for (const fleet::NodeOutput& output : outputs) state->take(output);
///     for (const fleet::NodeEvent& event : state->sync(now)) node.step(event, ...);
///
/// sync() blocks for as long as the disk takes (0.1 to 45 ms measured). It may run in a thread of
/// its own: it shares only facts with the node, and those never change.
class StateDir {
 public:
  /// Opens a vehicle's folder, or makes it. The epoch is raised and on the disk when this returns.
  /// Errors: kUsage if another process has the folder open, or if it belongs to another vehicle;
  /// kInput for a folder of a newer program, or without epochs left; kMachine.
  [[nodiscard]] static Result<StateDir> open(const std::string& folder, VehicleId self,
                                             const std::vector<VehicleId>& fleet,
                                             const StateSettings& settings = {});

  /// The same from a log and slots that the host keeps, such as those in memory.
  [[nodiscard]] static Result<StateDir> restore(std::shared_ptr<factlog::FactLog> log,
                                                std::shared_ptr<factlog::RoleSlots> slots,
                                                VehicleId self, const std::vector<VehicleId>& fleet,
                                                const StateSettings& settings = {});

  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  /// The start state of the node; to be taken once.
  [[nodiscard]] fleet::NodeStart take_start() { return std::move(start_); }

  /// False for other outputs. Facts are written but not synced yet.
  bool take(const fleet::NodeOutput& output);

  /// Writes and syncs what is due: a role always, facts after `sync_s` or `sync_facts`.
  /// @param now of the node's clock  @param all also facts that are not due yet, before an end
  /// @return events for the node: fleet::Persisted, fleet::PersistFailed
  [[nodiscard]] std::vector<fleet::NodeEvent> sync(Time now, bool all = false);

  /// Encoded counters of the messages that the link had accepted at the last save of an earlier
  /// start; empty if there is none.
  [[nodiscard]] const factlog::Bytes& seen() const { return seen_kept_; }

  /// Is on the disk after the next sync().
  void keep_seen(factlog::Bytes seen) { seen_ = std::move(seen); }

  /// Facts that wait for a sync, or could not be written yet.
  [[nodiscard]] std::size_t waiting() const { return unsynced_.size() + failing_.size(); }

  [[nodiscard]] std::uint64_t free_bytes() const { return log_->free_bytes(); }

  /// Findings about damage, torn ends, conflicts, an unreadable role.
  [[nodiscard]] FindingList take_findings();

 private:
  StateDir(std::shared_ptr<factlog::FactLog> log, std::shared_ptr<factlog::RoleSlots> slots,
           VehicleId self, const StateSettings& settings)
      : log_(std::move(log)), slots_(std::move(slots)), self_(self), settings_(settings) {}

  [[nodiscard]] Status read_role(const std::vector<VehicleId>& fleet);
  void read_facts(const std::vector<VehicleId>& fleet);
  [[nodiscard]] Status save_role(const fleet::DurableRole& durable);
  /// False: it must be tried again; `why` gives the reason.
  [[nodiscard]] bool write(const fleet::FactPtr& fact, std::string& why);
  void take_fact(const fleet::FactPtr& fact);
  void sync_facts(std::vector<fleet::FactKey>& kept);
  void sync_seen();
  void retry();
  void note_failure(const fleet::FactPtr& fact, std::string why);

  std::shared_ptr<factlog::FactLog> log_;
  std::shared_ptr<factlog::RoleSlots> slots_;
  VehicleId self_;
  StateSettings settings_;
  std::uint32_t epoch_ = 0;
  fleet::NodeStart start_;

  std::optional<fleet::SaveRole> role_;             ///< to be saved
  std::shared_ptr<factlog::RoleSlots> seen_slots_;  ///< null: not kept
  factlog::Bytes seen_, seen_kept_;
  std::uint64_t role_kept_ = 0;           ///< number of the last role that was saved
  std::vector<fleet::FactPtr> unsynced_;  ///< written since the last sync
  std::deque<fleet::FactPtr> failing_;    ///< to be tried again
  fleet::PersistFailed failed_;           ///< to be reported
  std::optional<Time> synced_, retried_;
  FindingList findings_;
};

}  // namespace rali::drive
