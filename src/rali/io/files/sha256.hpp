#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "rali/base/result.hpp"

struct evp_md_ctx_st;  // of OpenSSL

namespace rali::io {

/// SHA-256 for status.json (FIPS 180-4), using the processor's SHA instructions if available.
class Sha256 {
 public:
  using Digest = std::array<std::uint8_t, 32>;

  Sha256();

  void update(std::span<const std::byte> bytes);

  /// The digest of all bytes given so far. Call once.
  [[nodiscard]] Digest finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };

  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::span<const std::byte> bytes);

/// Digest of a file's content, read as a stream. Errors: kInput if it cannot be opened, kMachine
/// if reading fails.
[[nodiscard]] Result<std::string> sha256_file(const std::string& path);

}  // namespace rali::io
