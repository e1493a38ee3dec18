#include "rali/io/containers/chunk_loader.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "rali/io/containers/crc32.hpp"

namespace rali::io {

Result<std::string> ChunkLoader::load(const StoredChunk& chunk) {
  if (chunk.plain_bytes > bytes_max_ || chunk.available > bytes_max_) {
    return fmt::format("chunk of {} bytes is larger than the {} that are accepted",
                       std::max(chunk.plain_bytes, chunk.available), bytes_max_);
  }
  const std::uint64_t stored = std::min(chunk.available, chunk.stored_bytes);
  if (!chunk.packed()) {
    const Status status = load_plain(chunk.offset, std::min(stored, chunk.plain_bytes));
    if (!status) return tl::make_unexpected(status.error());
    return trouble_of(chunk, chunk.cut() ? DecodeEnd::kCut : DecodeEnd::kWhole);
  }
  packed_.resize(static_cast<std::size_t>(stored));
  if (const Status status = source_->read(chunk.offset, packed_); !status) {
    return tl::make_unexpected(status.error());
  }
  return trouble_of(
      chunk, decompressor_.decompress(chunk.compression, packed_, chunk.plain_bytes, bytes_));
}

Status ChunkLoader::load_plain(std::uint64_t offset, std::uint64_t bytes) {
  bytes_.resize(static_cast<std::size_t>(bytes));
  return source_->read(offset, bytes_);
}

std::string ChunkLoader::trouble_of(const StoredChunk& chunk, DecodeEnd end) const {
  if (end == DecodeEnd::kTooLong) return "chunk is longer than its header says; left out";
  if (end == DecodeEnd::kDamaged) {
    return fmt::format("chunk cannot be decompressed ({} data damaged); left out",
                       name_of(chunk.compression));
  }
  // The checksum covers the whole chunk, so it cannot verify a part.
  if (chunk.cut() || chunk.crc == 0) return {};
  const std::uint32_t crc = crc32(bytes_);
  if (crc == chunk.crc) return {};
  return fmt::format("checksum of the chunk is {:08x}, should be {:08x}; left out", crc, chunk.crc);
}

}  // namespace rali::io
