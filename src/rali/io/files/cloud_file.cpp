#include "rali/io/files/cloud_file.hpp"

#include <bit>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

static_assert(std::endian::native == std::endian::little,
              "clouds are handed on little endian without a swap");

template <class T>
double loaded(const std::byte* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return static_cast<double>(value);
}

double element(wire::FieldType type, const std::byte* p) {
  switch (type) {
    case wire::FieldType::kInt8:
      return loaded<std::int8_t>(p);
    case wire::FieldType::kUint8:
      return loaded<std::uint8_t>(p);
    case wire::FieldType::kInt16:
      return loaded<std::int16_t>(p);
    case wire::FieldType::kUint16:
      return loaded<std::uint16_t>(p);
    case wire::FieldType::kInt32:
      return loaded<std::int32_t>(p);
    case wire::FieldType::kUint32:
      return loaded<std::uint32_t>(p);
    case wire::FieldType::kFloat32:
      return loaded<float>(p);
    case wire::FieldType::kFloat64:
      return loaded<double>(p);
  }
  return 0.0;
}

}  // namespace

std::uint32_t field_bytes(wire::FieldType type) {
  switch (type) {
    case wire::FieldType::kInt8:
    case wire::FieldType::kUint8:
      return 1;
    case wire::FieldType::kInt16:
    case wire::FieldType::kUint16:
      return 2;
    case wire::FieldType::kInt32:
    case wire::FieldType::kUint32:
    case wire::FieldType::kFloat32:
      return 4;
    case wire::FieldType::kFloat64:
      return 8;
  }
  return 0;
}

int CloudFile::field(std::string_view name) const {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::vector<double> CloudFile::column(int field_index) const {
  RALI_ASSERT(field_index >= 0 && static_cast<std::size_t>(field_index) < fields.size());
  const wire::CloudField& wanted = fields[static_cast<std::size_t>(field_index)];
  RALI_ASSERT(wanted.offset + field_bytes(wanted.type) <= point_step);
  RALI_ASSERT(size() * point_step <= data.size());
  std::vector<double> values(size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = element(wanted.type, data.data() + i * point_step + wanted.offset);
  }
  return values;
}

wire::CloudView CloudFile::view(Time stamp, std::string frame_id) const {
  wire::CloudView cloud;
  cloud.stamp = stamp;
  cloud.frame_id = std::move(frame_id);
  cloud.height = height;
  cloud.width = width;
  cloud.point_step = point_step;
  cloud.row_step = width * point_step;  // fits: no file above kCloudBytesMax is read
  cloud.fields = fields;
  cloud.data = data;
  return cloud;
}

Result<CloudFile> parse_cloud_file(std::vector<std::byte> bytes, const std::string& path,
                                   const CloudFileOptions& options) {
  if (begins_pcd(bytes)) return parse_pcd(std::move(bytes), path);
  if (begins_ply(bytes)) return parse_ply(std::move(bytes), path);
  if (begins_las(bytes)) return parse_las(std::move(bytes), path);
  const std::string extension = lower_case(std::filesystem::path(path).extension().string());
  if (extension == ".pcd" && !bytes.empty()) return parse_pcd(std::move(bytes), path);
  if (extension == ".bin" && !has_known_kind(bytes)) {
    return parse_kitti(std::move(bytes), path, options.kitti);
  }
  return fail(
      ErrorCode::kInput, path,
      fmt::format("is {}, not a point cloud (PCD, PLY, LAS or KITTI .bin)", content_kind(bytes)));
}

Result<CloudFile> read_cloud_file(const std::string& path, const CloudFileOptions& options) {
  auto bytes = read_file(path, kCloudBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  return parse_cloud_file(std::move(*bytes), path, options);
}

}  // namespace rali::io
