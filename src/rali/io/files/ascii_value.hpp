#pragma once

#include <cstddef>
#include <string_view>

#include "rali/wire/cloud_format.hpp"

namespace rali::io {

/// Writes the number `word` as a little endian `type` to `out`, which must be large enough. False
/// if it is no number or out of range. Integer fields accept decimals only if they are zero.
[[nodiscard]] bool store_ascii_value(std::string_view word, wire::FieldType type, std::byte* out);

}  // namespace rali::io
