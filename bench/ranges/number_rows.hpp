#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::ranges_bench {

/// A file of rows of numbers.
struct NumberRows {
  std::vector<std::string> names;         ///< from the first line that starts with a letter
  std::vector<std::vector<double>> rows;  ///< empty cells and words are NaN
  std::size_t damaged = 0;                ///< lines with another number of cells, ignored

  /// Index of a column; -1 if it does not exist.
  [[nodiscard]] int column(std::string_view name) const;
};

/// Lines that start with # are skipped. With `separator` ' ' any whitespace separates. The first
/// line determines the number of cells. Errors (kInput): cannot be read; no row of numbers in it.
[[nodiscard]] Result<NumberRows> read_number_rows(const std::filesystem::path& path,
                                                  char separator);

/// The number in the text, or NaN if the whole text is not a number.
[[nodiscard]] double number_of(std::string_view text);

/// Parts between separators; with ' ' no part is empty.
[[nodiscard]] std::vector<std::string_view> split(std::string_view line, char separator);

}  // namespace rali::ranges_bench
