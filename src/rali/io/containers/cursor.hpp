#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace rali::io {

/// Bytes as text, without copying.
[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

[[nodiscard]] inline std::span<const std::byte> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

/// Little-endian numbers from a span. Reading past the end gives zeros and ok() == false, so a
/// parser checks once at the end instead of at each field.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }

  [[nodiscard]] std::size_t at() const { return at_; }

  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }

  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }

  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }

  std::uint64_t u64() { return number(8); }

  std::span<const std::byte> bytes(std::uint64_t n) {
    if (!ok_ || n > left()) {
      ok_ = false;
      return {};
    }
    const auto part = bytes_.subspan(at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return part;
  }

  /// Bytes preceded by their 32-bit count.
  std::span<const std::byte> bytes32() { return bytes(u32()); }

  std::string_view text32() { return text_of(bytes32()); }

  std::span<const std::byte> rest() { return bytes(left()); }

 private:
  std::uint64_t number(std::size_t n) {
    const auto part = bytes(n);
    std::uint64_t value = 0;
    for (std::size_t i = part.size(); i > 0; --i) {
      value = (value << 8) | std::to_integer<std::uint64_t>(part[i - 1]);
    }
    return value;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Appends little-endian numbers.
class Appender {
 public:
  explicit Appender(std::vector<std::byte>& out) : out_(out) {}

  void u8(std::uint8_t value) { number(value, 1); }

  void u16(std::uint16_t value) { number(value, 2); }

  void u32(std::uint32_t value) { number(value, 4); }

  void u64(std::uint64_t value) { number(value, 8); }

  void bytes(std::span<const std::byte> value) {
    out_.insert(out_.end(), value.begin(), value.end());
  }

  void text(std::string_view value) { bytes(bytes_of(value)); }

  /// Text preceded by its 32-bit length.
  void text32(std::string_view value) {
    u32(static_cast<std::uint32_t>(value.size()));
    text(value);
  }

 private:
  void number(std::uint64_t value, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      out_.push_back(static_cast<std::byte>(value >> (8 * i)));
    }
  }

  std::vector<std::byte>& out_;
};

}  // namespace rali::io
