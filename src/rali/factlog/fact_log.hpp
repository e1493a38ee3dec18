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
  kKnown,     ///< the same content is there: nothing was done
  kConflict,  ///< another content is there: it stays, see take_findings
  kFull       ///< no room: nothing was written, the log is as it was
};

/// Facts for good: an append-only log with an index by key. What was appended survives a loss of
/// power once sync() has returned; what was not is there wholly or not at all. Not thread-safe: one
/// thread owns it.
class FactLog {
 public:
  /// A record as it is read back. @return false: no more
  using Visit =
      std::function<bool(const RecordKey&, std::uint8_t kind, std::span<const std::byte>)>;

  virtual ~FactLog() = default;

  /// Errors: kInput for a body beyond kBodyMax; kMachine where the disk fails. After an error the
  /// log is as it was.
  [[nodiscard]] Result<Appended> append(const RecordKey& key, std::uint8_t kind,
                                        std::span<const std::byte> body);

  /// Returns when all that was appended is on the disk. Errors: kMachine; then nothing of what was
  /// appended since the last sync is in the log any more: append it again.
  [[nodiscard]] virtual Status sync() = 0;

  /// Errors: kNoAnswer if it is not there; kInput if its bytes have been damaged since they were
  /// indexed; kMachine.
  [[nodiscard]] Result<Bytes> read(const RecordKey& key) const;

  /// In the order in which they were appended. What cannot be read is left out, with a Finding.
  void for_each(const Visit& visit);

  [[nodiscard]] bool contains(const RecordKey& key) const { return index_.contains(key); }

  [[nodiscard]] std::size_t size() const { return index_.size(); }

  /// Bytes that can still be written.
  [[nodiscard]] virtual std::uint64_t free_bytes() const = 0;

  /// Damage, torn ends and conflicts that were met since the last call.
  [[nodiscard]] FindingList take_findings() { return std::exchange(findings_, {}); }

 protected:
  /// What the index holds of a record.
  struct Entry {
    RecordHead head;
    RecordPlace place;
  };

  /// Writes a record behind the last one. @return where; nothing: no room
  [[nodiscard]] virtual Result<std::optional<RecordPlace>> write(
      const RecordKey& key, std::uint8_t kind, std::span<const std::byte> body) = 0;

  [[nodiscard]] virtual Result<Bytes> body_of(const Entry& entry) const = 0;

  /// Notes a record that is written. False: its key is taken; the first one stays.
  bool index(const Entry& entry);

  /// The records at and behind this place are gone.
  void forget_from(const RecordPlace& place);

  void report(Finding finding) { findings_.push_back(std::move(finding)); }

 private:
  void report_conflict(const RecordKey& key);

  std::map<RecordKey, Entry> index_;
  std::map<std::pair<std::uint32_t, std::uint64_t>, RecordKey> by_place_;
  std::set<std::pair<VehicleId, std::uint32_t>> conflicts_;  ///< streams of which it was said
  FindingList findings_;
};

}  // namespace rali::factlog
