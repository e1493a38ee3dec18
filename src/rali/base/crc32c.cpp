#include "rali/base/crc32c.hpp"

#include <array>
#include <bit>
#include <cstring>

namespace rali {

namespace {

/// Table k is for a byte followed by k others: eight bytes at once, so that a log of gigabytes is
/// checked about as fast as it is read (Kounavis, Berry 2008: slicing by 8).
using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr Tables make_tables() {
  constexpr std::uint32_t kReflectedPolynomial = 0x82F63B78U;
  Tables tables{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1U) != 0 ? kReflectedPolynomial ^ (c >> 1) : c >> 1;
    tables[0][n] = c;
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t n = 0; n < 256; ++n) {
      const std::uint32_t before = tables[k - 1][n];
      tables[k][n] = tables[0][before & 0xFFU] ^ (before >> 8);
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

std::uint32_t of_byte(std::uint32_t c, std::byte b) {
  return kTables[0][(c ^ std::to_integer<std::uint32_t>(b)) & 0xFFU] ^ (c >> 8);
}

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
  std::uint32_t c = ~before;
  std::size_t i = 0;
  if constexpr (std::endian::native == std::endian::little) {
    for (; i + 8 <= bytes.size(); i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, sizeof(word));
      word ^= c;
      c = 0;
      for (std::size_t k = 0; k < 8; ++k) c ^= kTables[7 - k][(word >> (8 * k)) & 0xFFU];
    }
  }
  for (; i < bytes.size(); ++i) c = of_byte(c, bytes[i]);
  return ~c;
}

}  // namespace rali
