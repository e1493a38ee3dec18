#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "rali/wire/byte_writer.hpp"
#include "rali/wire/fleet/crc32c.hpp"

namespace rali::fuzz {

/// Bytes with the correct checksum of a message between vehicles; otherwise no message would pass.
inline wire::Bytes with_checksum(std::span<const std::byte> raw) {
  wire::Bytes bytes(raw.begin(), raw.end());
  constexpr std::size_t kSumAt = 6, kSumEnd = 10;
  if (bytes.size() < kSumEnd) return bytes;
  const std::span<const std::byte> all(bytes);
  const std::uint32_t sum = wire::crc32c(all.subspan(kSumEnd), wire::crc32c(all.first(kSumAt)));
  for (std::size_t k = 0; k < kSumEnd - kSumAt; ++k) {
    bytes[kSumAt + k] = static_cast<std::byte>(sum >> (8 * k) & 0xFFU);
  }
  return bytes;
}

/// Removes two bytes from the front, as a number; 0 at the end.
inline std::size_t take_number(std::span<const std::byte>& rest) {
  if (rest.size() < 2) {
    rest = {};
    return 0;
  }
  const std::size_t number =
      std::to_integer<std::size_t>(rest[0]) | std::to_integer<std::size_t>(rest[1]) << 8;
  rest = rest.subspan(2);
  return number;
}

/// Removes at most `length` bytes from the front.
inline std::span<const std::byte> take_bytes(std::span<const std::byte>& rest, std::size_t length) {
  const auto taken = rest.first(std::min(length, rest.size()));
  rest = rest.subspan(taken.size());
  return taken;
}

}  // namespace rali::fuzz
