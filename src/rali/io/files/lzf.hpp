#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace rali::io {

/// Decompresses LZF, the compression of PCD binary_compressed, into `out`, which must have exactly
/// the size of the content. Never reads or writes out of bounds, whatever `in` holds. On damage
/// returns the offset in `in` of the first invalid byte; nothing on success.
/// Format (Marc Lehmann, liblzf): a control byte below 32 is the number of following literals minus
/// one. Otherwise its upper 3 bits are length - 2 (7: one more byte of length follows); its lower 5
/// bits and the next byte are the distance back minus one.
[[nodiscard]] std::optional<std::size_t> lzf_decompress(std::span<const std::byte> in,
                                                        std::span<std::byte> out);

/// Upper bound of the content size of `bytes` of LZF: 264 bytes for each 3.
[[nodiscard]] inline std::size_t lzf_content_max(std::size_t bytes) { return bytes * 88 + 264; }

}  // namespace rali::io
