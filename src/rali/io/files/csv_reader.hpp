#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/io/files/input_file.hpp"

namespace rali::io {

/// Reads a CSV table row by row: first line of names, commas, cells in "quotes" where they hold
/// commas, quotes ("") or line ends. Accepts CRLF, a byte order mark, blank lines and
/// comment lines (#). Memory does not grow with the file. Errors: kInput with file and line.
class CsvReader {
 public:
  [[nodiscard]] static Result<CsvReader> open(const std::string& path);

  /// The same from memory; `name` is for messages.
  [[nodiscard]] static Result<CsvReader> from_text(std::string text, const std::string& name);

  /// Names of the columns, without blanks around them.
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }

  /// Index of a column by its current or old name (old_names.hpp), -1 if there is none.
  [[nodiscard]] int column(std::string_view name) const;

  /// Index of a required column. Errors: kInput with its name and the columns present.
  [[nodiscard]] Result<int> require(std::string_view name) const;

  /// True: a row is there. False: end.
  [[nodiscard]] Result<bool> next();

  /// Cell of the row without blanks around it; empty for column -1 and in rows that are too short.
  [[nodiscard]] std::string_view cell(int column) const;

  /// False where the row has more or fewer cells than the header.
  [[nodiscard]] bool complete() const { return cells_.size() == header_.size(); }

  /// Line of the file in which the row begins, from 1.
  [[nodiscard]] std::uint64_t line() const { return row_line_; }

  /// "file:line" of the row.
  [[nodiscard]] std::string where() const;

 private:
  CsvReader(std::optional<InputFile> file, std::string text, std::string name);

  [[nodiscard]] Status read_header();
  [[nodiscard]] Status check_first_bytes();
  [[nodiscard]] Status fill();
  [[nodiscard]] Result<bool> take_physical_line(std::string& out);
  [[nodiscard]] Result<bool> take_logical_line();
  [[nodiscard]] Status split();
  [[nodiscard]] tl::unexpected<Error> error(std::string what) const;

  std::optional<InputFile> file_;
  std::string name_;
  std::string buffer_;  ///< bytes read but not yet consumed, from buffer_at_ on
  std::size_t buffer_at_ = 0;
  bool at_end_ = false;
  std::uint64_t next_line_ = 1;
  std::uint64_t row_line_ = 0;
  std::string text_;                                        ///< of the row, as in the file
  std::string unquoted_;                                    ///< the cells one after the other
  std::vector<std::pair<std::size_t, std::size_t>> cells_;  ///< begin and end in unquoted_
  std::vector<std::string> header_;
};

}  // namespace rali::io
