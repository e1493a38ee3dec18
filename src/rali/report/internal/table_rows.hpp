#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "rali/base/time.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// One row of a CSV file, by the names of its columns.
class TableRow {
 public:
  explicit TableRow(const io::CsvReader& csv) : csv_(csv) {}

  /// kUnknown for an empty cell, an absent column and non-numbers.
  [[nodiscard]] double number(std::string_view column) const;
  [[nodiscard]] std::string text(std::string_view column) const;
  [[nodiscard]] bool flag(std::string_view column) const;  ///< 1 or true
  /// Seconds since `t_start`; exact, because stamps are read as whole nanoseconds.
  [[nodiscard]] double seconds(std::string_view column, Time t_start) const;

 private:
  const io::CsvReader& csv_;
};

/// Calls `take` for every row of dir/name. An absent file has none. Damage ends the reading and is
/// reported in RunData::unreadable. At most kRowsMax rows are read.
void read_table(const std::string& dir, const std::string& name, RunData& run,
                const std::function<void(const TableRow&)>& take);

inline constexpr std::size_t kRowsMax = 2'000'000;

}  // namespace rali::report
