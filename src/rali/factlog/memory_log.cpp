#include "rali/factlog/memory_log.hpp"

namespace rali::factlog {

Status MemoryLog::sync() {
  if (broken_) {
    forget_unsynced();
    return fail(ErrorCode::kMachine, "log in memory", "could not be synced");
  }
  synced_ = bodies_.size();
  return {};
}

Result<std::optional<RecordPlace>> MemoryLog::write(const RecordKey& /*key*/, std::uint8_t /*kind*/,
                                                    std::span<const std::byte> body) {
  const std::uint64_t needed = kRecordHeadBytes + body.size();
  if (needed > free_bytes()) return std::optional<RecordPlace>{};
  bytes_ += needed;
  bodies_.emplace_back(body.begin(), body.end());
  return std::optional(RecordPlace{0, bodies_.size() - 1});
}

Result<Bytes> MemoryLog::body_of(const Entry& entry) const {
  return bodies_[static_cast<std::size_t>(entry.place.offset)];
}

void MemoryLog::forget_unsynced() {
  forget_from({0, synced_});
  while (bodies_.size() > synced_) {
    bytes_ -= kRecordHeadBytes + bodies_.back().size();
    bodies_.pop_back();
  }
}

}  // namespace rali::factlog
