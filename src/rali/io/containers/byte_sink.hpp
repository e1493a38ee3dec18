#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

/// Destination of a recording: a file that appears complete under its name, or memory in tests.
class ByteSink {
 public:
  virtual ~ByteSink() = default;

  /// Appends.
  [[nodiscard]] virtual Status write(std::span<const std::byte> bytes) = 0;

  /// Replaces bytes already written. Only BagWriter needs it: the first record of a ROS 1 bag
  /// contains the offset of its index.
  [[nodiscard]] virtual Status overwrite(std::uint64_t offset,
                                         std::span<const std::byte> bytes) = 0;
};

/// Keeps what is written in memory.
class MemorySink final : public ByteSink {
 public:
  Status write(std::span<const std::byte> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
  }

  Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes) override {
    if (offset > bytes_.size() || bytes.size() > bytes_.size() - offset) {
      return fail(ErrorCode::kMachine, "memory", "overwrite beyond the end");
    }
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
    return {};
  }

  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace rali::io
