#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace rali::factlog {

/// Little endian on every machine.
template <class T>
void put(std::vector<std::byte>& out, T value) {
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * k) & 0xFFU));
  }
}

/// The caller checks the bounds.
template <class T>
[[nodiscard]] T get(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    value |= std::to_integer<std::uint64_t>(bytes[at + k]) << (8 * k);
  }
  return static_cast<T>(value);
}

}  // namespace rali::factlog
