#include "rali/io/files/imu_csv.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr const char* kValueNames[] = {"gx", "gy", "gz", "ax", "ay", "az"};

void count(std::uint64_t& n, std::uint64_t& first_line, std::uint64_t line) {
  if (n++ == 0) first_line = line;
}

Finding finding_of(const char* id, std::string text, std::uint64_t value) {
  Finding finding;
  finding.id = id;
  finding.text = std::move(text);
  finding.value = static_cast<double>(value);
  return finding;
}

}  // namespace

Result<ImuCsvReader> ImuCsvReader::open(const std::string& path) {
  auto csv = CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  return with_columns(std::move(*csv), path);
}

Result<ImuCsvReader> ImuCsvReader::from_text(std::string text, const std::string& name) {
  auto csv = CsvReader::from_text(std::move(text), name);
  if (!csv) return tl::make_unexpected(csv.error());
  return with_columns(std::move(*csv), name);
}

Result<ImuCsvReader> ImuCsvReader::with_columns(CsvReader csv, const std::string& name) {
  ImuCsvReader reader(std::move(csv), name);
  const auto stamp = reader.csv_.require("stamp_s");
  if (!stamp) return tl::make_unexpected(stamp.error());
  reader.stamp_ = *stamp;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto column = reader.csv_.require(kValueNames[i]);
    if (!column) return tl::make_unexpected(column.error());
    reader.values_[i] = *column;
  }
  return reader;
}

bool ImuCsvReader::take_row(sensor::ImuSample& out) {
  ++stats_.rows;
  double v[6] = {};
  bool is_nan = false;
  bool is_bad = !csv_.complete();
  const std::string_view stamp = csv_.cell(stamp_);
  const auto t = parse_stamp(stamp);
  if (!t) (stamp.empty() || parse_number(stamp) ? is_nan : is_bad) = true;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string_view cell = csv_.cell(values_[i]);
    const auto value = parse_number(cell);
    if (!value && !cell.empty()) is_bad = true;
    if (!value || !std::isfinite(*value)) is_nan = true;
    v[i] = value.value_or(0.0);
  }
  if (is_bad) {
    count(stats_.bad_rows, stats_.first_bad_line, csv_.line());
    return false;
  }
  if (is_nan) {
    count(stats_.nan_rows, stats_.first_nan_line, csv_.line());
    return false;
  }
  if (last_ && *t <= *last_) {
    count(stats_.back_rows, stats_.first_back_line, csv_.line());
    stats_.largest_step_back_s = std::max(stats_.largest_step_back_s, seconds_between(*t, *last_));
  }
  last_ = *t;
  ++stats_.used;
  out.t = *t;
  out.gyro_radps = geometry::Vec3(v[0], v[1], v[2]);
  out.accel_mps2 = geometry::Vec3(v[3], v[4], v[5]);
  return true;
}

Result<bool> ImuCsvReader::next(sensor::ImuSample& out) {
  while (true) {
    auto more = csv_.next();
    if (!more || !*more) return more;
    if (take_row(out)) return true;
  }
}

FindingList ImuCsvReader::findings() const {
  FindingList list;
  const ImuCsvStats& s = stats_;
  if (s.bad_rows > 0) {
    list.push_back(finding_of("imu.rows",
                              fmt::format("{}:{}: not seven numbers; {} of {} rows left out", name_,
                                          s.first_bad_line, s.bad_rows, s.rows),
                              s.bad_rows));
  }
  if (s.nan_rows > 0) {
    list.push_back(finding_of("imu.nan",
                              fmt::format("{}:{}: a value is not known; {} of {} rows left out",
                                          name_, s.first_nan_line, s.nan_rows, s.rows),
                              s.nan_rows));
  }
  if (s.back_rows > 0) {
    list.push_back(finding_of(
        "imu.order",
        fmt::format("{}:{}: time does not advance in {} of {} rows, at worst {:.6f} s back", name_,
                    s.first_back_line, s.back_rows, s.rows, s.largest_step_back_s),
        s.back_rows));
  }
  return list;
}

}  // namespace rali::io
