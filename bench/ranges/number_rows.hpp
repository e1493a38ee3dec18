#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::ranges_bench {

/// A file of rows of numbers.
struct NumberRows {
  std::vector<std::string> names;         ///< from the first line that begins with a letter
  std::vector<std::vector<double>> rows;  ///< empty cells and words are NaN
  std::size_t damaged = 0;                ///< lines with another number of cells, left out

  /// Place of a column; -1 if it is not there.
  [[nodiscard]] int column(std::string_view name) const;
};

/// Lines that begin with # are passed over. With `separator` ' ' any blanks separate. The first
/// line says how many cells a line has. Errors (kInput): cannot be read; no row of numbers in it.
[[nodiscard]] Result<NumberRows> read_number_rows(const std::filesystem::path& path,
                                                  char separator);

/// A number that fills the whole text, or NaN.
[[nodiscard]] double number_of(std::string_view text);

/// Pieces between separators; with ' ' no piece is empty.
[[nodiscard]] std::vector<std::string_view> split(std::string_view line, char separator);

}  // namespace rali::ranges_bench
