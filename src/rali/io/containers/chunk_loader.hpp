#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/codec.hpp"

namespace rali::io {

/// Position of a chunk and the contents of its header.
struct StoredChunk {
  Compression compression = Compression::kNone;
  std::uint64_t offset = 0;        ///< of its data in the file
  std::uint64_t stored_bytes = 0;  ///< as its header claims
  std::uint64_t available = 0;     ///< of these, present before the file ends or the next chunk
                                   ///< starts
  std::uint64_t plain_bytes = 0;   ///< decompressed, as claimed
  std::uint32_t crc = 0;           ///< of the decompressed bytes; 0: not given

  [[nodiscard]] bool packed() const { return compression != Compression::kNone; }

  [[nodiscard]] bool cut() const { return available < stored_bytes; }
};

/// Brings one chunk at a time into memory, decompressed and checked.
class ChunkLoader {
 public:
  ChunkLoader(std::shared_ptr<ByteSource> source, std::uint64_t bytes_max)
      : source_(std::move(source)), bytes_max_(bytes_max) {}

  /// Loads a chunk into bytes(); of a truncated one, the readable part. The result is empty, or the
  /// reason why the chunk must not be used. An Error is a disk failure.
  [[nodiscard]] Result<std::string> load(const StoredChunk& chunk);

  /// Loads bytes as they are. The caller has checked the size.
  [[nodiscard]] Status load_plain(std::uint64_t offset, std::uint64_t bytes);

  /// Valid until the next load.
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  [[nodiscard]] std::uint64_t bytes_max() const { return bytes_max_; }

 private:
  [[nodiscard]] std::string trouble_of(const StoredChunk& chunk, DecodeEnd end) const;

  std::shared_ptr<ByteSource> source_;
  std::uint64_t bytes_max_;
  Decompressor decompressor_;
  std::vector<std::byte> packed_;
  std::vector<std::byte> bytes_;
};

}  // namespace rali::io
