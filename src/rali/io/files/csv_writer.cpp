#include "rali/io/files/csv_writer.hpp"

#include <cmath>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {

void CsvRow::begin_cell() {
  if (cells_++ > 0) line_ += ',';
}

void CsvRow::clear() {
  line_.clear();
  cells_ = 0;
}

CsvRow& CsvRow::stamp(Time t) {
  begin_cell();
  line_ += format_stamp(t);
  return *this;
}

CsvRow& CsvRow::fixed(double value, int decimals) {
  begin_cell();
  if (std::isfinite(value)) line_ += format_fixed(value, decimals);
  return *this;
}

CsvRow& CsvRow::scientific(double value, int decimals) {
  begin_cell();
  if (std::isfinite(value)) line_ += fmt::format("{:.{}e}", value + 0.0, decimals);
  return *this;
}

CsvRow& CsvRow::integer(std::int64_t value) {
  begin_cell();
  line_ += fmt::format("{}", value);
  return *this;
}

CsvRow& CsvRow::text(std::string_view value) {
  begin_cell();
  // '#' would make the line a comment; blanks at the ends would be lost when read back.
  const bool plain = value.find_first_of(",\"\r\n#") == std::string_view::npos &&
                     trimmed(value).size() == value.size();
  if (plain) {
    line_ += value;
    return *this;
  }
  line_ += '"';
  for (const char c : value) {
    if (c == '"') line_ += '"';
    line_ += c;
  }
  line_ += '"';
  return *this;
}

CsvRow& CsvRow::empty() {
  begin_cell();
  return *this;
}

Result<CsvWriter> CsvWriter::create(const std::string& path,
                                    const std::vector<std::string>& columns) {
  auto file = StreamFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  CsvRow header;
  for (const std::string& column : columns) header.text(column);
  if (auto status = file->add(header.line() + "\n"); !status) {
    return tl::make_unexpected(status.error());
  }
  return CsvWriter(std::move(*file), columns.size());
}

Status CsvWriter::add(const CsvRow& row, Time t) {
  RALI_ASSERT(row.cells() == columns_);
  return file_.add(row.line() + "\n", t);
}

Status CsvWriter::add(const CsvRow& row) {
  RALI_ASSERT(row.cells() == columns_);
  return file_.add(row.line() + "\n");
}

}  // namespace rali::io
