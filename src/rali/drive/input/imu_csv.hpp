#pragma once

#include <array>
#include <optional>
#include <string>

#include "rali/base/result.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Reads imu.csv: stamp_s,gx,gy,gz,ax,ay,az (rad/s, m/s^2), columns by name in any order.
class ImuCsv {
 public:
  /// Errors: kInput (no file, a column that is missing).
  [[nodiscard]] static Result<ImuCsv> open(const std::string& path);

  /// The next sample, empty at the end. Rows that are no numbers are counted and passed over;
  /// what ends the reading is counted as damage.
  [[nodiscard]] std::optional<sensor::ImuSample> next(InputGaps& gaps, FindingList& findings);

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  ImuCsv(io::CsvReader reader, std::string path) : reader_(std::move(reader)), path_(path) {}

  [[nodiscard]] std::optional<sensor::ImuSample> sample() const;

  io::CsvReader reader_;
  std::string path_;
  std::array<int, 7> columns_{};
};

}  // namespace rali::drive
