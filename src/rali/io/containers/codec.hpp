#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

enum class Compression { kNone, kLz4, kBz2, kZstd };

/// "none", "lz4", "bz2", "zstd"; also the empty text, which is MCAP's "none".
[[nodiscard]] std::optional<Compression> compression_named(std::string_view name);
[[nodiscard]] std::string_view name_of(Compression compression);

/// How a decompression ended.
enum class DecodeEnd {
  kWhole,
  kCut,      ///< the input ended early; `out` holds the decoded part
  kDamaged,  ///< not decodable, or a checksum is wrong; `out` must not be used
  kTooLong   ///< more than `limit` bytes; `out` must not be used
};

/// Decompresses whole chunks; keeps its working memory from one to the next.
class Decompressor {
 public:
  Decompressor();
  ~Decompressor();
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  /// Replaces `out` by the decompressed bytes, at most `limit`. Memory grows with the actual
  /// output, because the claimed `limit` may be wrong. Frames may be concatenated; data after a
  /// frame that ends exactly at `limit` are ignored.
  [[nodiscard]] DecodeEnd decompress(Compression compression, std::span<const std::byte> in,
                                     std::uint64_t limit, std::vector<std::byte>& out);

 private:
  struct Contexts;
  std::unique_ptr<Contexts> contexts_;
};

/// Compresses into one frame; the same bytes for the same input. LZ4 as roslz4 writes it (frame
/// with content checksum), bz2 at level 9, zstd at level 1.
[[nodiscard]] Result<std::vector<std::byte>> compress(Compression compression,
                                                      std::span<const std::byte> in);

/// True if the bytes start a zstd frame.
[[nodiscard]] bool is_zstd(std::span<const std::byte> bytes);

}  // namespace rali::io
