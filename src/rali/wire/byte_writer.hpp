#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/wire/byte_reader.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::wire {

/// Bytes of one message.
using Bytes = std::vector<std::byte>;

/// Writes one message field by field; the counterpart of ByteReader. CDR is XCDR1, in the given
/// byte order (big endian is for tests: ROS 2 writes little endian).
class ByteWriter {
 public:
  explicit ByteWriter(Encoding encoding, bool big_endian = false);

  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    align(sizeof(T));
    if (big_endian_ != (std::endian::native == std::endian::big)) value = byte_swapped(value);
    const auto* raw = reinterpret_cast<const std::byte*>(&value);
    out_.insert(out_.end(), raw, raw + sizeof(T));
  }

  /// Zeros up to a multiple of `size` (nothing in ROS 1).
  void align(std::size_t size);
  void string(std::string_view text);

  void sequence(std::size_t length) { put(static_cast<std::uint32_t>(length)); }

  void bytes(std::span<const std::byte> raw) { out_.insert(out_.end(), raw.begin(), raw.end()); }

  void time(Time t);

  /// std_msgs/Header; the sequence number of ROS 1 is 0.
  void header(Time stamp, std::string_view frame_id);

  [[nodiscard]] Encoding encoding() const { return encoding_; }

  [[nodiscard]] Bytes take() { return std::move(out_); }

  void reserve(std::size_t size) { out_.reserve(size); }

 private:
  Bytes out_;
  Encoding encoding_;
  bool big_endian_;
  std::size_t origin_ = 0;
};

}  // namespace rali::wire
