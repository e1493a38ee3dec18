#include "rali/io/files/cloud_targets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/base/counted.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/record.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kLot = 4096;
constexpr std::string_view kScalar = "scalar_";
// Beyond this float32 resolves less than the millimetre of a LAS file.
constexpr double kFloatReach_m = 8192.0;

/// One-element fields, one per column; PLY and LAS have no arrays.
struct Column {
  std::string name;
  std::uint32_t offset = 0;
  wire::FieldType type = wire::FieldType::kFloat32;
};

std::vector<Column> single_columns(const CloudFile& cloud) {
  std::vector<Column> columns;
  for (const wire::CloudField& field : cloud.fields) {
    const std::uint32_t count = std::max<std::uint32_t>(field.count, 1);
    for (std::uint32_t k = 0; k < count; ++k) {
      std::string name = field.name;
      if (count > 1) name += fmt::format("_{}", k);
      columns.push_back({std::move(name), field.offset + k * field_bytes(field.type), field.type});
    }
  }
  return columns;
}

/// Writes header and rows; `row` appends one point.
template <class Row>
Status write_rows(const std::string& path, const std::string& header, std::size_t points,
                  const Row& row) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  if (Status status = file->write(std::string_view(header)); !status) return status;
  std::vector<std::byte> lot;
  for (std::size_t i = 0; i < points; ++i) {
    row(i, lot);
    if ((i + 1) % kLot != 0 && i + 1 != points) continue;
    if (Status status = file->write(lot); !status) return status;
    lot.clear();
  }
  return file->commit();
}

void append_bytes(const CloudFile& cloud, std::size_t point, std::uint32_t offset,
                  std::uint32_t bytes, std::vector<std::byte>& out) {
  const std::byte* from = cloud.data.data() + point * cloud.point_step + offset;
  out.insert(out.end(), from, from + bytes);
}

/// The columns of LAS and KITTI, as doubles; zeros without the field.
std::vector<double> column_or_zeros(const CloudFile& cloud, std::string_view name) {
  for (std::size_t i = 0; i < cloud.fields.size(); ++i) {
    if (cloud.fields[i].name == name) return cloud.column(static_cast<int>(i));
  }
  return std::vector<double>(cloud.size(), 0.0);
}

/// x y z, the points with finite coordinates, and a note on those left out.
struct FinitePoints {
  std::array<std::vector<double>, 3> p_m;
  std::vector<std::size_t> kept;
};

FinitePoints finite_points(const CloudFile& cloud, LostParts& lost) {
  FinitePoints points;
  points.p_m = {column_or_zeros(cloud, "x"), column_or_zeros(cloud, "y"),
                column_or_zeros(cloud, "z")};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool finite = std::isfinite(points.p_m[0][i]) && std::isfinite(points.p_m[1][i]) &&
                        std::isfinite(points.p_m[2][i]);
    if (finite) points.kept.push_back(i);
  }
  if (const std::size_t out = cloud.size() - points.kept.size(); out > 0) {
    lost.push_back(counted(out, "point") + " without finite coordinates");
  }
  return points;
}

void note_rows(const CloudFile& cloud, LostParts& lost) {
  if (cloud.height > 1) {
    lost.push_back(fmt::format("rows and columns of the {} x {} cloud", cloud.width, cloud.height));
  }
}

/// The fields that are not among `held`.
void note_fields(const CloudFile& cloud, std::span<const std::string_view> held, LostParts& lost) {
  std::vector<std::string> names;
  for (const wire::CloudField& field : cloud.fields) {
    const std::string name = field.name;
    if (std::find(held.begin(), held.end(), name) == held.end()) names.push_back(name);
  }
  if (!names.empty()) lost.push_back(fmt::format("fields {}", fmt::join(names, ", ")));
}

void note_viewpoint(const CloudFile& cloud, LostParts& lost) {
  if (cloud.viewpoint) lost.emplace_back("the VIEWPOINT of the PCD");
}

char pcd_type(wire::FieldType type) {
  using wire::FieldType;
  if (type == FieldType::kFloat32 || type == FieldType::kFloat64) return 'F';
  const bool is_signed =
      type == FieldType::kInt8 || type == FieldType::kInt16 || type == FieldType::kInt32;
  return is_signed ? 'I' : 'U';
}

std::string pcd_header(const CloudFile& cloud) {
  std::string fields = "FIELDS", size = "SIZE", type = "TYPE", count = "COUNT";
  for (const wire::CloudField& field : cloud.fields) {
    fields += ' ' + field.name;
    size += fmt::format(" {}", field_bytes(field.type));
    type += fmt::format(" {}", pcd_type(field.type));
    count += fmt::format(" {}", std::max<std::uint32_t>(field.count, 1));
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n{}\n{}\n{}\n{}\nWIDTH {}\n"
      "HEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      fields, size, type, count, cloud.width, cloud.height, cloud.size());
}

std::string_view ply_type(wire::FieldType type) {
  using wire::FieldType;
  switch (type) {
    case FieldType::kInt8:
      return "char";
    case FieldType::kUint8:
      return "uchar";
    case FieldType::kInt16:
      return "short";
    case FieldType::kUint16:
      return "ushort";
    case FieldType::kInt32:
      return "int";
    case FieldType::kUint32:
      return "uint";
    case FieldType::kFloat32:
      return "float";
    case FieldType::kFloat64:
      return "double";
  }
  return "float";
}

/// Names that PLY readers know; all others are scalar fields.
std::string ply_name(const std::string& name) {
  constexpr std::array<std::string_view, 12> kKnown = {
      "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha", "intensity", "confidence"};
  const bool known = std::find(kKnown.begin(), kKnown.end(), name) != kKnown.end();
  return known ? name : std::string(kScalar) + name;
}

/// All of `values` at `kept`, as T within its range.
template <class T>
std::vector<T> picked(const std::vector<double>& values, const std::vector<std::size_t>& kept) {
  std::vector<T> out;
  out.reserve(kept.size());
  for (const std::size_t i : kept) {
    double value = values[i];
    if constexpr (std::is_integral_v<T>) {
      constexpr auto kMax = static_cast<double>(std::numeric_limits<T>::max());
      value = std::isfinite(value) ? std::clamp(std::round(value), 0.0, kMax) : 0.0;
    }
    out.push_back(static_cast<T>(value));
  }
  return out;
}

}  // namespace

Result<LostParts> write_cloud_pcd(const std::string& path, const CloudFile& cloud) {
  LostParts lost;
  note_viewpoint(cloud, lost);
  const Status status = write_rows(
      path, pcd_header(cloud), cloud.size(), [&](std::size_t i, std::vector<std::byte>& out) {
        for (const wire::CloudField& field : cloud.fields) {
          const std::uint32_t count = std::max<std::uint32_t>(field.count, 1);
          append_bytes(cloud, i, field.offset, count * field_bytes(field.type), out);
        }
      });
  if (!status) return tl::make_unexpected(status.error());
  return lost;
}

Result<LostParts> write_cloud_ply(const std::string& path, const CloudFile& cloud) {
  LostParts lost;
  note_viewpoint(cloud, lost);
  note_rows(cloud, lost);
  const std::vector<Column> columns = single_columns(cloud);
  std::string header =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", cloud.size());
  for (const Column& column : columns) {
    header += fmt::format("property {} {}\n", ply_type(column.type), ply_name(column.name));
  }
  header += "end_header\n";
  const Status status =
      write_rows(path, header, cloud.size(), [&](std::size_t i, std::vector<std::byte>& out) {
        for (const Column& column : columns) {
          append_bytes(cloud, i, column.offset, field_bytes(column.type), out);
        }
      });
  if (!status) return tl::make_unexpected(status.error());
  return lost;
}

Result<LostParts> write_cloud_las(const std::string& path, const CloudFile& cloud) {
  constexpr std::array<std::string_view, 7> kHeld = {"x",     "y",    "z",      "intensity",
                                                     "sigma", "seen", "vehicle"};
  LostParts lost;
  note_viewpoint(cloud, lost);
  note_rows(cloud, lost);
  note_fields(cloud, kHeld, lost);
  FinitePoints points = finite_points(cloud, lost);
  LasOptions options;
  double reach_m = 0.0;
  std::array<std::vector<float>, 3> p_m;
  for (std::size_t k = 0; k < 3; ++k) {
    // Site coordinates exceed the precision of a float, the difference to the first point does not.
    if (!points.kept.empty()) {
      options.shift_m[k] = std::floor(points.p_m[k][points.kept.front()]);
    }
    for (double& value : points.p_m[k]) value -= options.shift_m[k];
    for (const std::size_t i : points.kept) {
      reach_m = std::max(reach_m, std::abs(points.p_m[k][i]));
    }
    p_m[k] = picked<float>(points.p_m[k], points.kept);
  }
  if (reach_m > kFloatReach_m) lost.emplace_back("millimetres beyond 8 km from the first point");
  const auto intensity = picked<float>(column_or_zeros(cloud, "intensity"), points.kept);
  const auto sigma_m = picked<float>(column_or_zeros(cloud, "sigma"), points.kept);
  const auto seen = picked<std::uint16_t>(column_or_zeros(cloud, "seen"), points.kept);
  const auto vehicle = picked<std::uint8_t>(column_or_zeros(cloud, "vehicle"), points.kept);
  options.intensity_scale = las_intensity_scale(intensity);
  const MapColumns columns{p_m[0], p_m[1], p_m[2], intensity, sigma_m, seen, vehicle};
  const Status status = write_map_las(path, columns.size(), one_part(columns), options);
  if (!status) return tl::make_unexpected(status.error());
  return lost;
}

Result<LostParts> write_cloud_kitti(const std::string& path, const CloudFile& cloud) {
  constexpr std::array<std::string_view, 4> kHeld = {"x", "y", "z", "intensity"};
  LostParts lost;
  note_viewpoint(cloud, lost);
  note_rows(cloud, lost);
  note_fields(cloud, kHeld, lost);
  const FinitePoints points = finite_points(cloud, lost);
  const std::vector<double> intensity = column_or_zeros(cloud, "intensity");
  bool rounded = false;
  const Status status =
      write_rows(path, "", points.kept.size(), [&](std::size_t n, std::vector<std::byte>& out) {
        const std::size_t i = points.kept[n];
        Record row;
        for (std::size_t k = 0; k < 3; ++k) {
          const auto stored = static_cast<float>(points.p_m[k][i]);
          rounded = rounded || std::abs(static_cast<double>(stored) - points.p_m[k][i]) > 0.0005;
          row.put(stored);
        }
        row.put(static_cast<float>(intensity[i]));
        out.insert(out.end(), row.bytes().begin(), row.bytes().end());
      });
  if (!status) return tl::make_unexpected(status.error());
  if (rounded) lost.emplace_back("millimetres: the coordinates are too large for float32");
  return lost;
}

}  // namespace rali::io
