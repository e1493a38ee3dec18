#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::wire {

/// Value of `bytes` (native order) with its bytes reversed.
template <class T>
[[nodiscard]] T byte_swapped(T value) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

/// Loads a T from unaligned bytes in the given byte order. The caller has checked the bounds.
template <class T>
[[nodiscard]] inline T load(const std::byte* from, bool big_endian) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  if constexpr (sizeof(T) > 1) {
    if (big_endian != (std::endian::native == std::endian::big)) value = byte_swapped(value);
  }
  return value;
}

/// Reads one serialised message field by field, of ROS 1 or ROS 2:
///
///   ROS 1   little endian, packed, strings without NUL
///   CDR     4 bytes of encapsulation header (byte order, XCDR1 or XCDR2), then fields aligned to
///           their size (at most 4 in XCDR2) counted from after the header, strings with NUL
///
/// Reading past the end yields zeros and makes ok() false permanently, so a decoder reads straight
/// through and checks once. No length read from the bytes leads to an allocation larger than the
/// message. Source: ROS wiki "msg"; OMG DDSI-RTPS 10.2, DDS-XTYPES 7.4.
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> message, Encoding encoding);

  [[nodiscard]] bool ok() const { return fault_ == nullptr; }

  [[nodiscard]] Encoding encoding() const { return encoding_; }

  [[nodiscard]] bool big_endian() const { return big_endian_; }

  [[nodiscard]] std::size_t remaining() const { return message_.size() - at_; }

  /// Offset in the message, header included.
  [[nodiscard]] std::size_t offset() const { return at_; }

  template <class T>
  [[nodiscard]] T get() {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    align(sizeof(T));
    if (!need(sizeof(T))) return T{};
    const T value = load<T>(message_.data() + at_, big_endian_);
    at_ += sizeof(T);
    return value;
  }

  template <class T, std::size_t N>
  [[nodiscard]] std::array<T, N> get_array() {
    std::array<T, N> values{};
    for (T& value : values) value = get<T>();
    return values;
  }

  void align(std::size_t size);
  void skip(std::size_t bytes);
  [[nodiscard]] std::string string();

  /// Length of a sequence whose elements take at least `element_bytes` (> 0); 0 and not ok() if
  /// fewer bytes remain.
  [[nodiscard]] std::uint32_t sequence(std::size_t element_bytes);

  /// The next `bytes` bytes, not copied.
  [[nodiscard]] std::span<const std::byte> bytes(std::size_t bytes);

  /// ROS 1: uint32 s, uint32 ns; ROS 2: int32 s, uint32 ns.
  [[nodiscard]] Time time();

  /// std_msgs/Header; in ROS 1 it begins with a sequence number, which is dropped.
  struct Header {
    Time stamp;
    std::string frame_id;
  };

  [[nodiscard]] Header header();

  /// The error of a reader that is not ok().
  [[nodiscard]] Error error(std::string_view type) const;

 private:
  void read_cdr_header();
  [[nodiscard]] bool need(std::size_t bytes);
  void fail_with(const char* fault);

  std::span<const std::byte> message_;
  std::size_t at_ = 0;
  std::size_t origin_ = 0;     ///< alignment is counted from here
  std::size_t align_max_ = 1;  ///< 1 for ROS 1, 8 for XCDR1, 4 for XCDR2
  Encoding encoding_;
  bool big_endian_ = false;
  const char* fault_ = nullptr;
  std::size_t fault_at_ = 0;
};

}  // namespace rali::wire
