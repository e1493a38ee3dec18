#pragma once

#include <cstddef>
#include <string_view>

#include "rali/wire/cloud_format.hpp"

namespace rali::io {

/// Writes the number `word` as a little endian `type` to `out`, which has room for it. False if it
/// is no number or does not fit; integer fields take decimals only where they are zero.
[[nodiscard]] bool store_ascii_value(std::string_view word, wire::FieldType type, std::byte* out);

}  // namespace rali::io
