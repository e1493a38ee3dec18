#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::io {

/// Counts of problems in an imu.csv.
struct ImuCsvStats {
  std::uint64_t rows = 0;
  std::uint64_t used = 0;
  std::uint64_t nan_rows = 0;   ///< a cell is empty, not a number or infinite: row left out
  std::uint64_t bad_rows = 0;   ///< a cell is not numeric, or cells are missing: row left out
  std::uint64_t back_rows = 0;  ///< stamp not after that of the previous row: returned nevertheless
  std::uint64_t first_nan_line = 0, first_bad_line = 0, first_back_line = 0;
  double largest_step_back_s = 0.0;
};

/// Reads inertial data row by row: `stamp_s,gx,gy,gz,ax,ay,az` (rad/s, m/s^2, IMU frame), columns
/// by name in any order, others ignored. Memory does not grow with the file.
class ImuCsvReader {
 public:
  /// Errors: kInput (no such file, a column is missing).
  [[nodiscard]] static Result<ImuCsvReader> open(const std::string& path);
  [[nodiscard]] static Result<ImuCsvReader> from_text(std::string text, const std::string& name);

  /// True: `out` holds the next sample. False: end. Errors: kInput where reading fails.
  [[nodiscard]] Result<bool> next(sensor::ImuSample& out);

  [[nodiscard]] const ImuCsvStats& stats() const { return stats_; }

  /// One sentence for each kind of problem so far.
  [[nodiscard]] FindingList findings() const;

 private:
  ImuCsvReader(CsvReader csv, std::string name) : csv_(std::move(csv)), name_(std::move(name)) {}

  [[nodiscard]] static Result<ImuCsvReader> with_columns(CsvReader csv, const std::string& name);
  [[nodiscard]] bool take_row(sensor::ImuSample& out);

  CsvReader csv_;
  std::string name_;
  int stamp_ = -1;
  int values_[6] = {-1, -1, -1, -1, -1, -1};
  ImuCsvStats stats_;
  std::optional<Time> last_;
};

}  // namespace rali::io
