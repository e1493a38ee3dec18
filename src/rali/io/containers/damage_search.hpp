#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "rali/io/containers/byte_source.hpp"

namespace rali::io {

/// Searches the damaged part of a file in blocks. Holes of a sparse file are not read, and blocks
/// of zeros are skipped. All searches in one file together have a limit: a file inflated to a
/// terabyte must not be read for hours.
class DamageSearch {
 public:
  static constexpr std::size_t kBlockBytes = 1U << 20;

  struct Block {
    std::uint64_t offset = 0;
    std::span<const std::byte> bytes;  ///< valid until the next call
  };

  explicit DamageSearch(std::uint64_t bytes_max) : bytes_left_(bytes_max) {}

  /// The first block at or after `from` that is not all zeros; none at the end of the file or at
  /// the limit.
  [[nodiscard]] Result<std::optional<Block>> next(ByteSource& source, ByteWindow& window,
                                                  std::uint64_t from);

  /// The limit was reached before the end of the file.
  [[nodiscard]] bool gave_up() const { return gave_up_; }

 private:
  std::uint64_t bytes_left_;
  bool gave_up_ = false;
};

/// Offset of the first non-zero byte at or after `from`, the file's size if there is none; nothing
/// if that takes more reading than `bytes_max`.
[[nodiscard]] Result<std::optional<std::uint64_t>> end_of_zeros(ByteSource& source,
                                                                ByteWindow& window,
                                                                std::uint64_t from,
                                                                std::uint64_t bytes_max);

}  // namespace rali::io
