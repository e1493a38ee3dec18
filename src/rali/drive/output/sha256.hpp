#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "rali/base/result.hpp"

namespace rali::drive {

/// SHA-256 of bytes that come in pieces. Source: FIPS 180-4, section 6.2.
class Sha256 {
 public:
  void add(std::span<const std::byte> data);
  /// 64 hexadecimal digits; the object must not be used afterwards.
  [[nodiscard]] std::string finish();

 private:
  void block(const std::uint8_t* bytes);

  std::array<std::uint32_t, 8> h_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                     0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> buffer_{};
  std::size_t filled_ = 0;
  std::uint64_t bytes_ = 0;
};

/// SHA-256 of a file's content. Errors: kMachine if it cannot be read.
[[nodiscard]] Result<std::string> sha256_of_file(const std::string& path);

}  // namespace rali::drive
