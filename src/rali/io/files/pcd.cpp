#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/ascii_value.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/lzf.hpp"
#include "rali/io/files/pcd_header.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

bool is_wide_integer(const PcdColumn& column) { return column.size == 8 && column.type != 'F'; }

wire::FieldType field_type(const PcdColumn& column) {
  if (column.type == 'F' || column.size == 8) {
    return column.size == 8 ? wire::FieldType::kFloat64 : wire::FieldType::kFloat32;
  }
  const bool is_signed = column.type == 'I';
  if (column.size == 1) return is_signed ? wire::FieldType::kInt8 : wire::FieldType::kUint8;
  if (column.size == 2) return is_signed ? wire::FieldType::kInt16 : wire::FieldType::kUint16;
  return is_signed ? wire::FieldType::kInt32 : wire::FieldType::kUint32;
}

CloudFile cloud_of(const PcdHeader& header, const std::string& path) {
  CloudFile cloud;
  cloud.kind = CloudFileKind::kPcd;
  cloud.width = static_cast<std::uint32_t>(header.width);
  cloud.height = static_cast<std::uint32_t>(header.height);
  cloud.point_step = static_cast<std::uint32_t>(header.point_step);
  cloud.viewpoint = header.viewpoint;
  std::uint32_t offset = 0;
  for (const PcdColumn& column : header.columns) {
    if (column.name != "_") {
      cloud.fields.push_back({column.name, offset, field_type(column), column.count});
    }
    offset += column.size * column.count;
  }
  if (!header.note.empty()) {
    Finding finding;
    finding.id = "cloud.header";
    finding.text = path + ": " + header.note;
    cloud.findings.push_back(std::move(finding));
  }
  return cloud;
}

/// PointCloud2 has no 64 bit integers: they are replaced by doubles.
void widen_integers(const PcdHeader& header, std::vector<std::byte>& data) {
  std::size_t offset = 0;
  for (const PcdColumn& column : header.columns) {
    for (std::uint32_t e = 0; e < column.count; ++e, offset += column.size) {
      if (!is_wide_integer(column)) continue;
      for (std::size_t at = offset; at + 8 <= data.size(); at += header.point_step) {
        std::int64_t bits = 0;
        std::memcpy(&bits, data.data() + at, 8);
        const double value = column.type == 'I'
                                 ? static_cast<double>(bits)
                                 : static_cast<double>(static_cast<std::uint64_t>(bits));
        std::memcpy(data.data() + at, &value, 8);
      }
    }
  }
}

tl::unexpected<Error> cut(const std::string& path, std::uint64_t have, std::uint64_t wanted) {
  return fail(ErrorCode::kInput, path,
              fmt::format("is cut: {} of {} points are there", have, wanted));
}

Result<std::vector<std::byte>> binary_points(const PcdHeader& header, std::vector<std::byte> bytes,
                                             const std::string& path) {
  const std::uint64_t wanted = header.points * header.point_step;
  const std::uint64_t have = bytes.size() - header.data_offset;
  if (have < wanted) return cut(path, have / header.point_step, header.points);
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header.data_offset));
  bytes.resize(static_cast<std::size_t>(wanted));
  return bytes;
}

/// binary_compressed holds all values of the first field, then all of the second, ...
std::vector<std::byte> interleaved(const PcdHeader& header, const std::vector<std::byte>& columns) {
  std::vector<std::byte> points(columns.size());
  std::size_t from = 0;
  std::size_t offset = 0;
  for (const PcdColumn& column : header.columns) {
    const std::size_t bytes = std::size_t{column.size} * column.count;
    for (std::size_t i = 0; i < header.points; ++i, from += bytes) {
      std::memcpy(points.data() + i * header.point_step + offset, columns.data() + from, bytes);
    }
    offset += bytes;
  }
  return points;
}

Result<std::vector<std::byte>> compressed_points(const PcdHeader& header,
                                                 const std::vector<std::byte>& bytes,
                                                 const std::string& path) {
  const std::uint64_t wanted = header.points * header.point_step;
  const std::size_t begin = header.data_offset + 8;
  if (bytes.size() < begin) {
    if (wanted == 0) return std::vector<std::byte>{};
    return fail(ErrorCode::kInput, path, "is cut: ends right after its header");
  }
  std::uint32_t packed = 0;
  std::uint32_t unpacked = 0;
  std::memcpy(&packed, bytes.data() + header.data_offset, 4);
  std::memcpy(&unpacked, bytes.data() + header.data_offset + 4, 4);
  const std::string where = fmt::format("{}:offset {}", path, header.data_offset);
  if (unpacked != wanted) {
    return fail(ErrorCode::kInput, where,
                fmt::format("holds {} bytes, but {} points of {} bytes are {}", unpacked,
                            header.points, header.point_step, wanted));
  }
  if (packed > bytes.size() - begin) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("is cut: {} of {} compressed bytes are there", bytes.size() - begin, packed));
  }
  if (unpacked > lzf_content_max(packed)) {
    return fail(ErrorCode::kInput, where,
                fmt::format("{} compressed bytes cannot stand for {}", packed, unpacked));
  }
  std::vector<std::byte> columns(unpacked);
  const auto damage = lzf_decompress(std::span(bytes).subspan(begin, packed), columns);
  if (damage) {
    return fail(ErrorCode::kInput, fmt::format("{}:offset {}", path, begin + *damage),
                "the compressed points are damaged");
  }
  return interleaved(header, columns);
}

/// Appends one line of an ascii file to `data`. On failure returns what was expected.
std::optional<std::string> append_ascii_point(const PcdHeader& header, std::string_view line,
                                              std::vector<std::byte>& data) {
  std::size_t at = data.size();
  data.resize(at + header.point_step);
  for (const PcdColumn& column : header.columns) {
    for (std::uint32_t e = 0; e < column.count; ++e, at += column.size) {
      const std::string_view word = take_word(line);
      const wire::FieldType type = field_type(column);
      if (word.empty()) return fmt::format("has no value for field {}", quoted(column.name));
      if (!store_ascii_value(word, type, data.data() + at)) {
        return fmt::format("{} is no value for field {}", quoted(word), quoted(column.name));
      }
    }
  }
  if (!trimmed(line).empty())
    return fmt::format("has more than the {} declared fields", header.columns.size());
  return std::nullopt;
}

Result<std::vector<std::byte>> ascii_points(const PcdHeader& header,
                                            const std::vector<std::byte>& bytes,
                                            const std::string& path) {
  std::string_view rest = as_text(bytes).substr(header.data_offset);
  // A value takes at least two characters, so the header cannot claim more than the file holds.
  std::uint64_t values = 0;
  for (const PcdColumn& column : header.columns) values += column.count;
  const std::uint64_t lines_max = rest.size() / (2 * values) + 1;
  std::vector<std::byte> data;
  data.reserve(static_cast<std::size_t>(std::min(header.points, lines_max) * header.point_step));
  std::uint64_t points = 0;
  std::string_view line;
  for (std::size_t n = header.data_line; points < header.points && take_line(rest, line); ++n) {
    if (trimmed(line).empty()) continue;
    const bool last_and_cut = rest.empty() && bytes.back() != std::byte{'\n'};
    if (const auto wrong = append_ascii_point(header, line, data)) {
      if (last_and_cut) return cut(path, points, header.points);
      return fail(ErrorCode::kInput, fmt::format("{}:{}", path, n), *wrong);
    }
    ++points;
  }
  if (points < header.points) return cut(path, points, header.points);
  return data;
}

}  // namespace

Result<CloudFile> parse_pcd(std::vector<std::byte> bytes, const std::string& path) {
  const auto header = parse_pcd_header(bytes, path);
  if (!header) return tl::make_unexpected(header.error());
  CloudFile cloud = cloud_of(*header, path);
  Result<std::vector<std::byte>> points;
  if (header->encoding == PcdEncoding::kAscii) {
    cloud.encoding = "ascii";
    points = ascii_points(*header, bytes, path);
  } else if (header->encoding == PcdEncoding::kBinary) {
    cloud.encoding = "binary";
    points = binary_points(*header, std::move(bytes), path);
  } else {
    cloud.encoding = "binary_compressed";
    points = compressed_points(*header, bytes, path);
  }
  if (!points) return tl::make_unexpected(points.error());
  cloud.data = std::move(*points);
  if (header->encoding != PcdEncoding::kAscii) widen_integers(*header, cloud.data);
  return cloud;
}

}  // namespace rali::io
