#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "rali/factlog/fact_log.hpp"

namespace rali::factlog {

/// A log without a disk, for tests and simulated vehicles.
class MemoryLog final : public FactLog {
 public:
  explicit MemoryLog(std::uint64_t capacity_bytes = std::numeric_limits<std::uint64_t>::max())
      : capacity_(capacity_bytes) {}

  [[nodiscard]] Status sync() override;

  [[nodiscard]] std::uint64_t free_bytes() const override {
    return capacity_ > bytes_ ? capacity_ - bytes_ : 0;
  }

  /// Changes the capacity; existing records are kept.
  void set_capacity(std::uint64_t bytes) { capacity_ = bytes; }

  /// The next syncs fail, as on a broken disk.
  void break_syncs(bool broken) { broken_ = broken; }

  /// As after a power loss: unsynced records are gone.
  void lose_power() { forget_unsynced(); }

 private:
  [[nodiscard]] Result<std::optional<RecordPlace>> write(const RecordKey& key, std::uint8_t kind,
                                                         std::span<const std::byte> body) override;
  [[nodiscard]] Result<Bytes> body_of(const Entry& entry) const override;
  void forget_unsynced();

  std::uint64_t capacity_, bytes_ = 0;
  std::vector<Bytes> bodies_;  ///< RecordPlace::offset is the index
  std::size_t synced_ = 0;     ///< bodies
  bool broken_ = false;
};

}  // namespace rali::factlog
