#include "rali/report/internal/table_rows.hpp"

#include <fmt/format.h>

#include "rali/io/files/text.hpp"
#include "rali/report/internal/read_parts.hpp"

namespace rali::report {

double TableRow::number(std::string_view column) const {
  return io::parse_number(csv_.cell(csv_.column(column))).value_or(kUnknown);
}

std::string TableRow::text(std::string_view column) const {
  return std::string(csv_.cell(csv_.column(column)));
}

bool TableRow::flag(std::string_view column) const {
  const std::string_view cell = csv_.cell(csv_.column(column));
  return cell == "1" || cell == "true";
}

double TableRow::seconds(std::string_view column, Time t_start) const {
  const std::optional<Time> t = io::parse_stamp(csv_.cell(csv_.column(column)));
  return t ? seconds_between(t_start, *t) : kUnknown;
}

void read_table(const std::string& dir, const std::string& name, RunData& run,
                const std::function<void(const TableRow&)>& take) {
  const std::string path = dir + '/' + name;
  if (!file_exists(path)) return;
  Result<io::CsvReader> csv = io::CsvReader::open(path);
  if (!csv) {
    run.unreadable.push_back(fmt::format("{}: {}", name, csv.error().what));
    return;
  }
  for (std::size_t rows = 0;; ++rows) {
    const Result<bool> more = csv->next();
    if (!more) run.unreadable.push_back(fmt::format("{}: {}", name, more.error().what));
    if (!more || !*more) return;
    if (rows >= kRowsMax) {
      run.unreadable.push_back(fmt::format("{}: only the first {} rows are shown", name, kRowsMax));
      return;
    }
    take(TableRow(*csv));
  }
}

}  // namespace rali::report
