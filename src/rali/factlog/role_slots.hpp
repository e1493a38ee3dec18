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

/// State that must be on the disk before an answer is sent, in two alternating slots: if a write is
/// interrupted, the other slot has the previous state.
class RoleSlots {
 public:
  enum class State {
    kNew,        ///< nothing was ever saved, or the very first save was interrupted
    kRead,       ///< see content()
    kUnreadable  ///< something was saved, but neither slot is readable
  };

  virtual ~RoleSlots() = default;

  [[nodiscard]] State state() const { return state_; }

  /// As last saved.
  [[nodiscard]] const Bytes& content() const { return content_; }

  /// One of two used slots is unreadable: interrupted, or damaged later.
  [[nodiscard]] bool one_is_damaged() const { return one_is_damaged_; }

  /// Returns when it is on the disk. Errors: kInput beyond kSlotContentMax bytes; kMachine, then
  /// the previous state is kept.
  [[nodiscard]] Status save(std::span<const std::byte> content);

 protected:
  /// Decodes both slots as read.
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
  /// Creates the file at its full size if it is absent, so that a full disk does not prevent
  /// voting. @param folder its directory, whose entry is synced. Errors: kMachine.
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

  /// As after a restart of the program.
  [[nodiscard]] MemorySlots reopened() const {
    MemorySlots slots;
    slots.bytes_ = bytes_;
    slots.take(slots.bytes_);
    return slots;
  }

  /// For simulating damage.
  [[nodiscard]] Bytes& bytes() { return bytes_; }

 private:
  [[nodiscard]] Status write(std::size_t slot, std::span<const std::byte> bytes) override;

  Bytes bytes_;
};

}  // namespace rali::factlog
