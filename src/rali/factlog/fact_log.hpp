#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/factlog/record.hpp"

namespace rali::factlog {

enum class Appended {
  kWritten,
  kKnown,     ///< the same content exists: nothing was done
  kConflict,  ///< another content exists and is kept, see take_findings
  kFull       ///< no room: nothing was written, the log is unchanged
};

/// Permanent storage of facts: an append-only log with an index by key. Appended records survive a
/// power loss once sync() has returned; before that each is there wholly or not at all. Not
/// thread-safe: one thread owns it.
class FactLog {
 public:
  /// Receives a record that was read. @return false: stop
  using Visit =
      std::function<bool(const RecordKey&, std::uint8_t kind, std::span<const std::byte>)>;

  virtual ~FactLog() = default;

  /// Errors: kInput for a body beyond kBodyMax; kMachine if the disk fails. After an error the log
  /// is unchanged.
  [[nodiscard]] Result<Appended> append(const RecordKey& key, std::uint8_t kind,
                                        std::span<const std::byte> body);

  /// Returns when all appended records are on the disk. Errors: kMachine; then all records since
  /// the last sync are removed from the log: append them again.
  [[nodiscard]] virtual Status sync() = 0;

  /// Errors: kNoAnswer if it is not there; kInput if its bytes have been damaged since they were
  /// indexed; kMachine.
  [[nodiscard]] Result<Bytes> read(const RecordKey& key) const;

  /// In the order of appending. Unreadable records are left out, with a Finding.
  void for_each(const Visit& visit);

  [[nodiscard]] bool contains(const RecordKey& key) const { return index_.contains(key); }

  [[nodiscard]] std::size_t size() const { return index_.size(); }

  /// Bytes that can still be written.
  [[nodiscard]] virtual std::uint64_t free_bytes() const = 0;

  /// Damage, torn ends and conflicts detected since the last call.
  [[nodiscard]] FindingList take_findings() { return std::exchange(findings_, {}); }

 protected:
  /// Index entry of a record.
  struct Entry {
    RecordHead head;
    RecordPlace place;
  };

  /// Writes a record after the last one. @return its place; nothing: no room
  [[nodiscard]] virtual Result<std::optional<RecordPlace>> write(
      const RecordKey& key, std::uint8_t kind, std::span<const std::byte> body) = 0;

  [[nodiscard]] virtual Result<Bytes> body_of(const Entry& entry) const = 0;

  /// Adds a written record to the index. False: its key exists; the first record is kept.
  bool index(const Entry& entry);

  /// Removes the records at and after this place.
  void forget_from(const RecordPlace& place);

  void report(Finding finding) { findings_.push_back(std::move(finding)); }

 private:
  void report_conflict(const RecordKey& key);

  std::map<RecordKey, Entry> index_;
  std::map<std::pair<std::uint32_t, std::uint64_t>, RecordKey> by_place_;
  std::set<std::pair<VehicleId, std::uint32_t>> conflicts_;  ///< streams already reported
  FindingList findings_;
};

}  // namespace rali::factlog
