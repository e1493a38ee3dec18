#include "rali/drive/input/imu_csv.hpp"

#include <utility>

#include "rali/io/files/text.hpp"

namespace rali::drive {

Result<ImuCsv> ImuCsv::open(const std::string& path) {
  Result<io::CsvReader> reader = io::CsvReader::open(path);
  if (!reader) return tl::make_unexpected(reader.error());
  ImuCsv csv(std::move(*reader), path);
  const std::array<const char*, 7> names = {"stamp_s", "gx", "gy", "gz", "ax", "ay", "az"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Result<int> column = csv.reader_.require(names[i]);
    if (!column) return tl::make_unexpected(column.error());
    csv.columns_[i] = *column;
  }
  return csv;
}

std::optional<sensor::ImuSample> ImuCsv::sample() const {
  sensor::ImuSample sample;
  const std::optional<Time> t = io::parse_stamp(reader_.cell(columns_[0]));
  if (!t) return std::nullopt;
  sample.t = *t;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<double> gyro = io::parse_number(reader_.cell(columns_[1 + axis]));
    const std::optional<double> accel = io::parse_number(reader_.cell(columns_[4 + axis]));
    if (!gyro || !accel) return std::nullopt;
    sample.gyro_radps[static_cast<Eigen::Index>(axis)] = *gyro;
    sample.accel_mps2[static_cast<Eigen::Index>(axis)] = *accel;
  }
  return sample;
}

std::optional<sensor::ImuSample> ImuCsv::next(InputGaps& gaps, FindingList& findings) {
  while (true) {
    const Result<bool> row = reader_.next();
    if (!row) {
      gaps.damaged = true;
      Finding f;
      f.id = "D19";
      f.topic = path_;
      f.text = row.error().message();
      findings.push_back(std::move(f));
      return std::nullopt;
    }
    if (!*row) return std::nullopt;
    if (std::optional<sensor::ImuSample> s = sample()) return s;
    ++gaps.imu_invalid;
  }
}

}  // namespace rali::drive
