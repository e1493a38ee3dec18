#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/record.hpp"

namespace rali::io {
namespace {

// Offsets and sizes: ASPRS, "LAS Specification 1.4 - R15", tables 3 and 7 to 17.
constexpr std::size_t kHeaderBytesMin = 227;
constexpr std::size_t kHeaderBytes14 = 375;
constexpr std::uint8_t kCompressedBits = 0xC0;  // LASzip sets the two upper bits of the format
constexpr std::size_t kVlrHeaderBytes = 54;
constexpr std::size_t kExtraBytesRecordBytes = 192;
constexpr std::uint16_t kExtraBytesRecordId = 4;
constexpr std::uint8_t kExtraFloat = 9;

/// Offsets of the fields in a point format; 0: absent.
struct PointLayout {
  std::uint16_t bytes, classification, point_source, gps_time;
};

constexpr std::array<PointLayout, 11> kLayouts = {{{20, 15, 18, 0},
                                                   {28, 15, 18, 20},
                                                   {26, 15, 18, 0},
                                                   {34, 15, 18, 20},
                                                   {57, 15, 18, 20},
                                                   {63, 15, 18, 20},
                                                   {30, 16, 20, 22},
                                                   {36, 16, 20, 22},
                                                   {38, 16, 20, 22},
                                                   {59, 16, 20, 22},
                                                   {67, 16, 20, 22}}};
constexpr std::uint16_t kIntensityAt = 12;

template <class T>
T at(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof value <= bytes.size()) {
    std::memcpy(&value, bytes.data() + offset, sizeof value);
  }
  return value;
}

struct LasHeader {
  PointLayout layout = {};
  std::uint64_t data_offset = 0, points = 0;
  std::uint16_t point_bytes = 0, header_bytes = 0;
  std::uint32_t records = 0;
  std::array<double, 3> scale = {}, offset_m = {};
};

Result<LasHeader> read_header(const std::vector<std::byte>& bytes, const std::string& path) {
  if (bytes.size() < kHeaderBytesMin) return fail(ErrorCode::kInput, path, "ends in its header");
  LasHeader header;
  header.header_bytes = at<std::uint16_t>(bytes, 94);
  header.data_offset = at<std::uint32_t>(bytes, 96);
  header.records = at<std::uint32_t>(bytes, 100);
  const auto format = at<std::uint8_t>(bytes, 104);
  if ((format & kCompressedBits) != 0) {
    return fail(ErrorCode::kInput, path, "is compressed (LAZ)", "Decompress it first.");
  }
  if (format >= kLayouts.size()) {
    return fail(ErrorCode::kInput, path, fmt::format("has the unknown point format {}", format));
  }
  header.layout = kLayouts[format];
  header.point_bytes = at<std::uint16_t>(bytes, 105);
  header.points = at<std::uint32_t>(bytes, 107);
  const bool counts_in_64_bits = at<std::uint8_t>(bytes, 25) >= 4 &&
                                 header.header_bytes >= kHeaderBytes14 &&
                                 bytes.size() >= kHeaderBytes14;
  if (counts_in_64_bits) header.points = at<std::uint64_t>(bytes, 247);
  for (std::size_t k = 0; k < 3; ++k) {
    header.scale[k] = at<double>(bytes, 131 + 8 * k);
    header.offset_m[k] = at<double>(bytes, 155 + 8 * k);
  }
  const std::uint64_t room =
      header.data_offset <= bytes.size() ? bytes.size() - header.data_offset : 0;
  if (header.point_bytes < header.layout.bytes || header.points > room / header.point_bytes) {
    return fail(ErrorCode::kInput, path,
                fmt::format("names {} points of {} bytes; {} bytes of points are there",
                            header.points, header.point_bytes, room));
  }
  return header;
}

std::uint16_t extra_bytes_of(std::uint8_t type) {
  constexpr std::array<std::uint16_t, 11> kBytes = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return type < kBytes.size() ? kBytes[type] : 0;
}

/// Offset of the extra dimension "sigma" within a point, 0 without.
std::size_t sigma_offset(const std::vector<std::byte>& bytes, const LasHeader& header) {
  std::size_t record = header.header_bytes;
  for (std::uint32_t n = 0; n < header.records; ++n) {
    if (record + kVlrHeaderBytes > bytes.size()) return 0;
    const std::size_t length = at<std::uint16_t>(bytes, record + 20);
    std::size_t entry = record + kVlrHeaderBytes;
    const std::size_t end = entry + length;
    if (at<std::uint16_t>(bytes, record + 18) == kExtraBytesRecordId && end <= bytes.size()) {
      std::size_t offset = header.layout.bytes;
      for (; entry + kExtraBytesRecordBytes <= end; entry += kExtraBytesRecordBytes) {
        const auto type = at<std::uint8_t>(bytes, entry + 2);
        const std::string_view name(reinterpret_cast<const char*>(bytes.data() + entry + 4), 6);
        const bool fits = offset + sizeof(float) <= header.point_bytes;
        if (type == kExtraFloat && name == std::string_view("sigma\0", 6) && fits) return offset;
        if (extra_bytes_of(type) == 0) return 0;  // its length is not in the table
        offset += extra_bytes_of(type);
      }
    }
    record = end;
  }
  return 0;
}

}  // namespace

Result<CloudFile> parse_las(std::vector<std::byte> bytes, const std::string& path) {
  const auto header = read_header(bytes, path);
  if (!header) return tl::make_unexpected(header.error());
  const std::size_t sigma_at = sigma_offset(bytes, *header);
  using wire::FieldType;
  CloudFile cloud;
  cloud.kind = CloudFileKind::kLas;
  cloud.encoding = "binary";
  const auto add_field = [&](const char* name, FieldType type) {
    cloud.fields.push_back({name, cloud.point_step, type, 1});
    cloud.point_step += field_bytes(type);
  };
  for (const char* name : {"x", "y", "z"}) add_field(name, FieldType::kFloat64);
  add_field("intensity", FieldType::kUint16);
  add_field("classification", FieldType::kUint8);
  add_field("point_source", FieldType::kUint16);
  if (header->layout.gps_time != 0) add_field("gps_time", FieldType::kFloat64);
  if (sigma_at != 0) add_field("sigma", FieldType::kFloat32);
  if (header->points > kCloudBytesMax / cloud.point_step) {
    return fail(ErrorCode::kInput, path, "is larger than 4 GiB");
  }
  cloud.width = static_cast<std::uint32_t>(header->points);
  Record rows;
  for (std::uint64_t i = 0; i < header->points; ++i) {
    const std::size_t point = header->data_offset + i * header->point_bytes;
    for (std::size_t k = 0; k < 3; ++k) {
      rows.put(at<std::int32_t>(bytes, point + 4 * k) * header->scale[k] + header->offset_m[k]);
    }
    rows.put(at<std::uint16_t>(bytes, point + kIntensityAt));
    rows.put(at<std::uint8_t>(bytes, point + header->layout.classification));
    rows.put(at<std::uint16_t>(bytes, point + header->layout.point_source));
    if (header->layout.gps_time != 0) rows.put(at<double>(bytes, point + header->layout.gps_time));
    if (sigma_at != 0) rows.put(at<float>(bytes, point + sigma_at));
  }
  cloud.data.assign(rows.bytes().begin(), rows.bytes().end());
  return cloud;
}

}  // namespace rali::io
