#include "rali/io/files/ascii_value.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

template <class T>
bool store_integer(std::string_view word, std::byte* out) {
  auto value = parse_integer(word);
  if (!value) {  // "12.0", written by programs that support only floats
    const auto number = parse_number(word);
    if (!number || !(std::abs(*number) < 1e15) || *number != std::floor(*number)) return false;
    value = static_cast<std::int64_t>(*number);
  }
  if (*value < std::int64_t{std::numeric_limits<T>::min()} ||
      *value > std::int64_t{std::numeric_limits<T>::max()}) {
    return false;
  }
  const T stored = static_cast<T>(*value);
  std::memcpy(out, &stored, sizeof stored);
  return true;
}

bool store_float(std::string_view word, std::byte* out) {
  const auto value = parse_number(word);
  if (!value) return false;
  constexpr double kMax = static_cast<double>(std::numeric_limits<float>::max());
  const bool fits = std::abs(*value) <= kMax || !std::isfinite(*value);
  if (!fits) return false;
  const auto stored = static_cast<float>(*value);
  std::memcpy(out, &stored, sizeof stored);
  return true;
}

}  // namespace

bool store_ascii_value(std::string_view word, wire::FieldType type, std::byte* out) {
  switch (type) {
    case wire::FieldType::kInt8:
      return store_integer<std::int8_t>(word, out);
    case wire::FieldType::kUint8:
      return store_integer<std::uint8_t>(word, out);
    case wire::FieldType::kInt16:
      return store_integer<std::int16_t>(word, out);
    case wire::FieldType::kUint16:
      return store_integer<std::uint16_t>(word, out);
    case wire::FieldType::kInt32:
      return store_integer<std::int32_t>(word, out);
    case wire::FieldType::kUint32:
      return store_integer<std::uint32_t>(word, out);
    case wire::FieldType::kFloat32:
      return store_float(word, out);
    case wire::FieldType::kFloat64: {
      const auto value = parse_number(word);
      if (!value) return false;
      std::memcpy(out, &*value, sizeof *value);
      return true;
    }
  }
  return false;
}

}  // namespace rali::io
