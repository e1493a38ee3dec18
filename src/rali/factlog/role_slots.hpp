#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "rali/base/result.hpp"
#include "rali/factlog/file.hpp"
#include "rali/factlog/record.hpp"

namespace rali::factlog {

inline constexpr std::size_t kSlotBytes = 4096;
inline constexpr std::size_t kSlotHeadBytes = 24;
inline constexpr std::size_t kSlotContentMax = kSlotBytes - kSlotHeadBytes;

/// What must be on the disk before an answer leaves, in one of two slots in turn: whatever is cut
/// short, the other slot has what was saved before.
class RoleSlots {
 public:
  enum class State {
    kNew,        ///< nothing was ever saved, or the very first save was cut short
    kRead,       ///< see content()
    kUnreadable  ///< something was saved, and neither slot can be read
  };

  virtual ~RoleSlots() = default;

  [[nodiscard]] State state() const { return state_; }

  /// As last saved.
  [[nodiscard]] const Bytes& content() const { return content_; }

  /// One of two used slots cannot be read: cut short, or damaged later.
  [[nodiscard]] bool one_is_damaged() const { return one_is_damaged_; }

  /// Returns when it is on the disk. Errors: kInput beyond kSlotContentMax bytes; kMachine, then
  /// what was saved before holds.
  [[nodiscard]] Status save(std::span<const std::byte> content);

 protected:
  /// What both slots hold, as it was read.
  void take(std::span<const std::byte> slots);

  /// Writes and syncs a slot, 0 or 1.
  [[nodiscard]] virtual Status write(std::size_t slot, std::span<const std::byte> bytes) = 0;

 private:
  State state_ = State::kNew;
  Bytes content_;
  std::uint64_t counter_ = 0;
  bool one_is_damaged_ = false;
};

/// In a file of two slots.
class DiskSlots final : public RoleSlots {
 public:
  /// Makes the file at its full size if it is not there, so that a full disk is no reason not to
  /// vote. @param folder where it is, for its name to be synced. Errors: kMachine.
  [[nodiscard]] static Result<DiskSlots> open(const std::string& folder, const std::string& name);

 private:
  explicit DiskSlots(File file) : file_(std::move(file)) {}

  [[nodiscard]] Status write(std::size_t slot, std::span<const std::byte> bytes) override;

  File file_;
};

/// Without a disk, for tests and simulated vehicles.
class MemorySlots final : public RoleSlots {
 public:
  MemorySlots() : bytes_(2 * kSlotBytes) {}

  /// As a new program finds them.
  [[nodiscard]] MemorySlots reopened() const {
    MemorySlots slots;
    slots.bytes_ = bytes_;
    slots.take(slots.bytes_);
    return slots;
  }

  /// For damage.
  [[nodiscard]] Bytes& bytes() { return bytes_; }

 private:
  [[nodiscard]] Status write(std::size_t slot, std::span<const std::byte> bytes) override;

  Bytes bytes_;
};

}  // namespace rali::factlog
