#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace rali::io {

/// Little endian numbers in sequence.
class Record {
 public:
  template <class T>
  Record& put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
    return *this;
  }

  /// Characters, padded with zeros to `length`.
  Record& put_text(const char* text, std::size_t length) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + length);
    for (std::size_t i = 0; i < length && text[i] != '\0'; ++i) {
      bytes_[at + i] = static_cast<std::byte>(text[i]);
    }
    return *this;
  }

  Record& put_zeros(std::size_t n) {
    bytes_.resize(bytes_.size() + n);
    return *this;
  }

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

  void clear() { bytes_.clear(); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace rali::io
