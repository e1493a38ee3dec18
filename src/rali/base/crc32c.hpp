#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace rali {

/// CRC-32C (Castagnoli, polynomial 0x1EDC6F41, as in iSCSI). Pass the result as `before` to
/// continue. Of "123456789": 0xE3069283.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace rali
