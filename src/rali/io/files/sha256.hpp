#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

/// SHA-256 for status.json. Source: FIPS 180-4, section 6.2.
class Sha256 {
 public:
  using Digest = std::array<std::uint8_t, 32>;

  void update(std::span<const std::byte> bytes);

  /// The digest of all bytes given so far. Call once.
  [[nodiscard]] Digest finish();

 private:
  void compress(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_ = {0x6a09e667U, 0xbb67ae85U, 0x3c6ef372U, 0xa54ff53aU,
                                         0x510e527fU, 0x9b05688cU, 0x1f83d9abU, 0x5be0cd19U};
  std::array<std::uint8_t, 64> block_ = {};
  std::size_t filled_ = 0;
  std::uint64_t length_bytes_ = 0;
};

/// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::span<const std::byte> bytes);

/// Digest of a file's content, read as a stream. Errors: kInput if it cannot be opened, kMachine
/// if reading fails.
[[nodiscard]] Result<std::string> sha256_file(const std::string& path);

}  // namespace rali::io
