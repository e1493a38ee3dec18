#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace rali {

/// "1 sweep", "2 sweeps", "0 sweeps": a number with its word, for words whose plural ends in s.
[[nodiscard]] inline std::string counted(std::integral auto n, std::string_view word) {
  std::string text = std::to_string(n) + ' ';
  text += word;
  if (n != 1) text += 's';
  return text;
}

}  // namespace rali
