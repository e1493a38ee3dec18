#include "rali/results.hpp"

#include <array>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// NaN for an empty cell (unknown).
double number(const io::CsvReader& csv, int column) {
  const std::string_view cell = csv.cell(column);
  if (cell.empty()) return kUnknown;
  const auto value = io::parse_number(cell);
  if (!value) {
    throw InputError(csv.where(), fmt::format("'{}' is no number", cell.substr(0, 60)), "");
  }
  return *value;
}

std::int64_t stamp(const io::CsvReader& csv, int column) {
  const auto value = io::parse_stamp(csv.cell(column));
  if (!value) {
    throw InputError(csv.where(), fmt::format("'{}' is no time", csv.cell(column).substr(0, 60)),
                     "");
  }
  return value->ns;
}

/// Upper triangle c00..c55 of a row.
Covariance6 covariance(const io::CsvReader& csv, const std::array<int, 21>& columns) {
  Covariance6 result;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      result(row, column) = result(column, row) = number(csv, columns[next++]);
    }
  }
  return result;
}

void read_covariances(const std::string& path, Trajectory& trajectory) {
  io::CsvReader csv = api::value_or_throw(io::CsvReader::open(path));
  std::array<int, 21> columns{};
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      columns[next++] = api::value_or_throw(csv.require(fmt::format("c{}{}", row, column)));
    }
  }
  const int stamp_column = api::value_or_throw(csv.require("stamp_s"));
  std::map<std::int64_t, Covariance6> rows;
  while (api::value_or_throw(csv.next())) {
    rows.emplace(stamp(csv, stamp_column), covariance(csv, columns));
  }
  for (const std::int64_t t : trajectory.stamp_ns) {
    const auto found = rows.find(t);
    trajectory.covariances.push_back(
        found != rows.end() ? found->second : Covariance6(Covariance6::Constant(kUnknown)));
  }
}

/// "x/y.tum" -> "x/y.cov.csv"; empty if there is no such file.
std::string covariance_file(const std::string& path) {
  std::filesystem::path file(path);
  file.replace_extension(".cov.csv");
  std::error_code error;
  return std::filesystem::is_regular_file(file, error) ? file.string() : std::string();
}

/// A field by its name or its name in CloudCompare; empty if there is none.
template <class T>
std::vector<T> column(const io::CloudFile& cloud, const std::string& name) {
  int field = cloud.field(name);
  if (field < 0) field = cloud.field("scalar_" + name);
  if (field < 0) return {};
  const std::vector<double> values = cloud.column(field);
  std::vector<T> result;
  result.reserve(values.size());
  for (const double value : values) result.push_back(static_cast<T>(value));
  return result;
}

}  // namespace

Trajectory read_trajectory(const std::string& path) {
  io::TumFile tum = api::value_or_throw(io::read_tum(path));
  Trajectory trajectory;
  for (const io::StampedPose& pose : tum.poses) {
    trajectory.stamp_ns.push_back(pose.t.ns);
    trajectory.poses.push_back(api::public_pose(pose.T));
  }
  trajectory.header = std::move(tum.header);
  const std::string covariances = covariance_file(path);
  if (!covariances.empty()) read_covariances(covariances, trajectory);
  return trajectory;
}

MapCloud read_map(const std::string& path) {
  const io::CloudFile cloud = api::value_or_throw(io::read_cloud_file(path));
  MapCloud map;
  map.xyz_m.resize(3 * cloud.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<float> values = column<float>(cloud, std::string(1, "xyz"[axis]));
    if (values.size() != cloud.size()) {
      throw InputError(path, "has no fields x, y and z", "Give a cloud.");
    }
    for (std::size_t i = 0; i < values.size(); ++i) map.xyz_m[3 * i + axis] = values[i];
  }
  map.intensity = column<float>(cloud, "intensity");
  map.sigma_m = column<float>(cloud, "sigma");
  map.seen = column<std::uint16_t>(cloud, "seen");
  map.vehicle = column<std::uint8_t>(cloud, "vehicle");
  return map;
}

RangeTable read_ranges(const std::string& path) {
  io::CsvReader csv = api::value_or_throw(io::CsvReader::open(path));
  const int stamp_column = api::value_or_throw(csv.require("stamp_s"));
  const int from = api::value_or_throw(csv.require("from"));
  const int to = api::value_or_throw(csv.require("to"));
  const int range = api::value_or_throw(csv.require("range_m"));
  RangeTable table;
  const std::array<std::pair<int, std::vector<double>*>, 6> numbers{
      {{range, &table.range_m},
       {csv.column("predicted_m"), &table.predicted_m},
       {csv.column("residual_m"), &table.residual_m},
       {csv.column("sigma_m"), &table.sigma_m},
       {csv.column("bias_m"), &table.bias_m},
       {csv.column("p_los"), &table.p_los}}};
  const int used = csv.column("used"), reason = csv.column("reason");
  while (api::value_or_throw(csv.next())) {
    table.stamp_ns.push_back(stamp(csv, stamp_column));
    table.from.emplace_back(csv.cell(from));
    table.to.emplace_back(csv.cell(to));
    for (const auto& [column, values] : numbers) values->push_back(number(csv, column));
    table.used.push_back(csv.cell(used) == "1" ? 1 : 0);
    table.reason.emplace_back(csv.cell(reason));
  }
  return table;
}

}  // namespace rali
