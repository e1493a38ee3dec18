#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "rali/fleet/facts/rounding.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/wire/byte_reader.hpp"
#include "rali/wire/byte_writer.hpp"

/// Fields of messages between vehicles: little endian, packed. Writer and reader have the same
/// members, so that one function (layout) defines the order of fields for both.
namespace rali::wire {

/// Variable-length integers: 7 bits per byte, low ones first; the top bit is set if more follow.
/// Signed numbers are mapped 0, -1, 1, -2, ... -> 0, 1, 2, 3, ...
[[nodiscard]] constexpr std::uint64_t zigzag(std::int64_t v) {
  return (static_cast<std::uint64_t>(v) << 1) ^ static_cast<std::uint64_t>(v >> 63);
}

[[nodiscard]] constexpr std::int64_t unzigzag(std::uint64_t v) {
  return static_cast<std::int64_t>(v >> 1) ^ -static_cast<std::int64_t>(v & 1U);
}

class PackWriter {
 public:
  static constexpr bool kReads = false;

  template <class T>
  void number(const T& value) {
    out_.put(value);
  }

  template <class E>
  void choice(const E& value, E /*last*/) {
    out_.put(static_cast<std::uint8_t>(value));
  }

  void flag(bool value) { out_.put(static_cast<std::uint8_t>(value ? 1 : 0)); }

  void varint(std::uint64_t value);

  void signed_varint(std::int64_t value) { varint(zigzag(value)); }

  void text(const std::string& value, std::size_t maximum);

  void bytes(std::span<const std::byte> raw) { out_.bytes(raw); }

  void real(double value) { out_.put(value); }

  void as_float(double value) { out_.put(static_cast<float>(value)); }

  void float3(const geometry::Vec3& v);
  void double3(const geometry::Vec3& v);
  void rotation(const geometry::Mat3& R);
  void pose(const geometry::SE3& T);
  void scaled(const geometry::Mat3& m);
  void information(const geometry::Mat6& m);
  template <int N>
  void covariance(const fleet::SquareMatrix<N>& m);

  template <class T, class Each>
  void list(const std::vector<T>& values, std::size_t /*most*/, Each&& each) {
    varint(values.size());
    for (const T& value : values) each(*this, value);
  }

  template <class Optional, class Each>
  void maybe(const Optional& value, Each&& each) {
    flag(value.has_value());
    if (value) each(*this, *value);
  }

  [[nodiscard]] Bytes take() { return out_.take(); }

 private:
  ByteWriter out_{Encoding::kRos1};
};

/// Reads the output of PackWriter. After a fault all fields are zero and ok() stays false.
class PackReader {
 public:
  static constexpr bool kReads = true;

  explicit PackReader(std::span<const std::byte> bytes) : in_(bytes, Encoding::kRos1) {}

  [[nodiscard]] bool ok() const { return in_.ok() && fault_ == nullptr; }

  /// The fault, if not ok().
  [[nodiscard]] const char* fault() const { return fault_ != nullptr ? fault_ : "ends too early"; }

  [[nodiscard]] std::size_t offset() const { return in_.offset(); }

  [[nodiscard]] std::size_t remaining() const { return in_.remaining(); }

  void fail_with(const char* fault) {
    if (ok()) fault_ = fault;
  }

  template <class T>
  void number(T& value) {
    value = in_.get<T>();
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) fail_with("holds a value that is not a number");
    }
  }

  template <class E>
  void choice(E& value, E last) {
    const auto raw = in_.get<std::uint8_t>();
    if (raw > static_cast<std::uint8_t>(last)) fail_with("holds an unknown choice");
    value = static_cast<E>(raw <= static_cast<std::uint8_t>(last) ? raw : 0);
  }

  void flag(bool& value) {
    const auto raw = in_.get<std::uint8_t>();
    if (raw > 1) fail_with("holds a flag that is neither 0 nor 1");
    value = raw == 1;
  }

  template <class T>
  void varint(T& value) {
    const std::uint64_t wide = get_varint();
    value = static_cast<T>(wide);
    if (static_cast<std::uint64_t>(value) != wide) fail_with("holds too large a number");
  }

  void signed_varint(std::int64_t& value) { value = unzigzag(get_varint()); }

  void text(std::string& value, std::size_t maximum);

  [[nodiscard]] std::span<const std::byte> rest() { return in_.bytes(in_.remaining()); }

  [[nodiscard]] std::span<const std::byte> bytes(std::size_t n) { return in_.bytes(n); }

  void real(double& value) { number(value); }

  void as_float(double& value) {
    float narrow = 0.0F;
    number(narrow);
    value = static_cast<double>(narrow);
  }

  void float3(geometry::Vec3& v);
  void double3(geometry::Vec3& v);
  void rotation(geometry::Mat3& R);
  void pose(geometry::SE3& T);
  void scaled(geometry::Mat3& m);
  void information(geometry::Mat6& m);
  template <int N>
  void covariance(fleet::SquareMatrix<N>& m);

  /// Allocates no more than the bytes justify: each element takes at least one of them.
  template <class T, class Each>
  void list(std::vector<T>& values, std::size_t maximum, Each&& each) {
    const std::uint64_t n = get_varint();
    values.clear();
    if (n > maximum || n > remaining()) return fail_with("holds too long a list");
    for (std::uint64_t k = 0; k < n && ok(); ++k) {
      values.emplace_back();
      each(*this, values.back());
    }
  }

  template <class Optional, class Each>
  void maybe(Optional& value, Each&& each) {
    bool there = false;
    flag(there);
    value.reset();
    if (!there) return;
    value.emplace();
    each(*this, *value);
  }

 private:
  [[nodiscard]] std::uint64_t get_varint();
  [[nodiscard]] std::int32_t get24();

  ByteReader in_;
  const char* fault_ = nullptr;
};

/// A body is a sequence of sections: tag, length, content. A reader skips unknown tags, so a
/// section may be added at the end; the content of a released section never changes.
class BodyWriter {
 public:
  static constexpr bool kReads = false;

  template <class Fill>
  void section(std::uint8_t tag, Fill&& fill) {
    PackWriter content;
    fill(content);
    const Bytes bytes = content.take();
    out_.number(tag);
    out_.varint(bytes.size());
    out_.bytes(bytes);
  }

  /// A section that is left out if not needed.
  template <class Fill>
  void optional_section(std::uint8_t tag, bool needed, Fill&& fill) {
    if (needed) section(tag, fill);
  }

  /// Sections copied unchanged.
  void append(std::span<const std::byte> sections) { out_.bytes(sections); }

  [[nodiscard]] Bytes take() { return out_.take(); }

 private:
  PackWriter out_;
};

class BodyReader {
 public:
  static constexpr bool kReads = true;

  explicit BodyReader(std::span<const std::byte> body);

  [[nodiscard]] bool ok() const { return fault_ == nullptr; }

  [[nodiscard]] const char* fault() const { return fault_; }

  /// A required section; `fill` must consume all of it.
  template <class Fill>
  void section(std::uint8_t tag, Fill&& fill) {
    PackReader content(take(tag));
    if (!ok()) return;
    fill(content);
    if (!content.ok()) {
      fault_ = content.fault();
    } else if (content.remaining() != 0) {
      fault_ = "has a section that is longer than its content";
    }
  }

  template <class Fill>
  void optional_section(std::uint8_t tag, bool /*needed*/, Fill&& fill) {
    if (has(tag)) section(tag, fill);
  }

  /// Tag, length and content of all sections that were not read, in their order.
  [[nodiscard]] std::vector<std::uint8_t> unread() const;

 private:
  struct Section {
    std::uint8_t tag = 0;
    bool read = false;
    std::span<const std::byte> whole, content;
  };

  [[nodiscard]] std::span<const std::byte> take(std::uint8_t tag);
  [[nodiscard]] bool has(std::uint8_t tag) const;

  std::vector<Section> sections_;
  const char* fault_ = nullptr;
};

}  // namespace rali::wire
