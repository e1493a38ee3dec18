#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace rali::io {

/// Undoes LZF, the compression of PCD binary_compressed, into `out`, which must have exactly the
/// size of the content. Nothing in `in` makes it read or write outside. On damage returns the
/// offset in `in` at which it no longer makes sense; nothing when all went well.
/// Format (Marc Lehmann, liblzf): a control byte below 32 says how many literals follow, less one;
/// else its upper 3 bits are length - 2 (7: a byte more of length follows) and its lower 5 bits
/// with the next byte the distance back, less one.
[[nodiscard]] std::optional<std::size_t> lzf_decompress(std::span<const std::byte> in,
                                                        std::span<std::byte> out);

/// The largest content that `bytes` of LZF can stand for: 264 bytes for each 3.
[[nodiscard]] inline std::size_t lzf_content_max(std::size_t bytes) { return bytes * 88 + 264; }

}  // namespace rali::io
