#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace rali {

/// "1 scan", "2 scans", "0 scans": a number with its noun, for nouns whose plural ends in s.
[[nodiscard]] inline std::string counted(std::integral auto n, std::string_view word) {
  std::string text = std::to_string(n) + ' ';
  text += word;
  if (n != 1) text += 's';
  return text;
}

}  // namespace rali
