#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/files/stream_file.hpp"

namespace rali::io {

/// Cells of one row, from left to right. A value that is not finite becomes an empty cell: unknown.
class CsvRow {
 public:
  CsvRow& stamp(Time t);                      ///< seconds, nine decimals
  CsvRow& fixed(double value, int decimals);  ///< 1.500
  CsvRow& scientific(double value, int decimals);
  CsvRow& integer(std::int64_t value);
  CsvRow& text(std::string_view value);  ///< quoted if necessary
  CsvRow& empty();

  [[nodiscard]] std::size_t cells() const { return cells_; }

  /// The row without its line end.
  [[nodiscard]] const std::string& line() const { return line_; }

  void clear();

 private:
  void begin_cell();

  std::string line_;
  std::size_t cells_ = 0;
};

/// Writes a table (product.md section 1: header line, comma, "\n"), as a stream.
class CsvWriter {
 public:
  [[nodiscard]] static Result<CsvWriter> create(const std::string& path,
                                                const std::vector<std::string>& columns);

  /// The row must have as many cells as there are columns. `t`: its data time, for the 10 s flush
  /// interval of StreamFile.
  [[nodiscard]] Status add(const CsvRow& row, Time t);
  [[nodiscard]] Status add(const CsvRow& row);

  [[nodiscard]] Status finish() { return file_.finish(); }

 private:
  CsvWriter(StreamFile file, std::size_t columns) : file_(std::move(file)), columns_(columns) {}

  StreamFile file_;
  std::size_t columns_;
};

}  // namespace rali::io
