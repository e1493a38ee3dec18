#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace rali::io {

/// CRC-32 of IEEE 802.3 (as in zip and MCAP). Pass the result as `before` to continue.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace rali::io
