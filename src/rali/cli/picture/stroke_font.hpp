#pragma once

#include <string_view>

namespace rali::cli {

/// How a character is drawn with a pen: "xy xy xy|xy xy", one digit each, '|' lifts the pen. x from
/// 0; y from 0 (top of capitals) over 2 (top of small letters) to 6 (base line) and 8.
[[nodiscard]] std::string_view strokes_of(char c);

/// Lines of capitals between top and base line.
inline constexpr double kCapitalUnits = 6.0;

}  // namespace rali::cli
