#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/facts/seq_set.hpp"
#include "rali/fleet/messages/messages.hpp"

namespace rali::fleet {

/// Limits on the memory that other vehicles can make a vehicle use (middleware 4.2).
struct StoreLimits {
  std::size_t streams = 1024;
  std::size_t gaps = 4096;  ///< of all streams
  std::size_t facts = 2000000;
};

/// All facts a vehicle has, its own and those of others. A fact is identical whatever its source,
/// so order and repetition have no effect: a set with union (algorithms_fleet 11.2).
class FactStore {
 public:
  /// Result of adding a fact.
  enum class Added {
    kNew,
    kKnown,
    kConflict,  ///< other content under the same key: the first one is kept, see take_findings
    kRefused    ///< unknown vehicle, or beyond the limits
  };

  /// @param fleet the vehicles whose facts are accepted
  FactStore(VehicleId self, std::vector<VehicleId> fleet, StoreLimits limits = {});

  /// Adds a fact of this vehicle, quantised as it is sent (quantise.hpp).
  /// @return the quantised one. Errors: those of quantised(); kInput for a fact of another vehicle,
  /// a
  ///                 number used before, or beyond the limits
  [[nodiscard]] Result<FactPtr> add_own(const Fact& fact);

  /// Adds a fact received from another vehicle, in any order.
  Added add(FactPtr fact);

  /// Adds a fact, own or foreign, that was stored on disk before the program's start.
  Added restore(FactPtr fact);

  /// From now on an inventory names only facts that are confirmed to be on the disk (I5). Without a
  /// log every fact counts as persisted.
  void keep_log() { logs_ = true; }

  /// With a log: returns each fact once that must be written to it.
  [[nodiscard]] std::vector<FactPtr> take_unsaved() { return std::exchange(unsaved_, {}); }

  /// With a log: the fact is on the disk. No effect if there is no such fact.
  void persisted(const FactKey& key);

  /// Each fact once, own and foreign, in order of arrival.
  [[nodiscard]] std::vector<FactPtr> take_new();

  [[nodiscard]] FindingList take_findings();

  [[nodiscard]] FactPtr find(const FactKey& key) const;

  /// Numbers held of a stream; empty if none.
  [[nodiscard]] const SeqSet& held(const StreamKey& stream) const;

  /// By key. @param first, last numbers, both included; calls visit(FactPtr), which returns false
  /// to stop.
  template <class Visit>
  void for_each(const StreamKey& stream, std::uint32_t first, std::uint32_t last,
                Visit&& visit) const {
    const auto found = streams_.find(stream);
    if (found == streams_.end()) return;
    const auto& facts = found->second.facts;
    for (auto it = facts.lower_bound(first); it != facts.end() && it->first <= last; ++it) {
      if (!visit(it->second.fact)) return;
    }
  }

  /// Facts that are on the disk: others may rely on them.
  [[nodiscard]] Inventory inventory(std::uint32_t number, std::uint64_t free_bytes) const;

  /// All facts held, on the disk or not yet. Ascending by key.
  [[nodiscard]] std::vector<StreamInventory> streams() const;

  /// Hash of all keys and contents: equal on two vehicles that hold the same facts.
  [[nodiscard]] std::uint64_t hash() const;

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] VehicleId self() const { return self_; }

  [[nodiscard]] const std::vector<VehicleId>& fleet() const { return fleet_; }

  /// How many facts were refused.
  [[nodiscard]] std::size_t refused() const { return refused_; }

 private:
  struct Entry {
    FactPtr fact;
    std::uint64_t hash = 0;
  };

  struct Stream {
    std::map<std::uint32_t, Entry> facts;
    SeqSet held;
    SeqSet on_disk;  ///< of those held; used with a log
    bool conflict_reported = false;
  };

  [[nodiscard]] bool within_limits(const FactKey& key) const;
  void report_conflict(const FactKey& key, Time t, Stream& stream);

  VehicleId self_;
  std::vector<VehicleId> fleet_;  ///< ascending
  StoreLimits limits_;
  std::map<StreamKey, Stream> streams_;
  std::size_t size_ = 0, gaps_ = 0, refused_ = 0;
  bool logs_ = false;
  std::vector<FactPtr> new_, unsaved_;
  FindingList findings_;
};

}  // namespace rali::fleet
