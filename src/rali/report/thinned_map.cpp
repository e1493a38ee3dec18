#include "rali/report/thinned_map.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/pcd_header.hpp"
#include "rali/io/files/ply_header.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kHeadBytes = 256U << 10, kChunkBytes = 1U << 20;
constexpr std::uint64_t kWholeBytesMax = 256ULL << 20;

/// Position of the points in a file that stores them contiguously.
struct Layout {
  io::CloudFile shape;  ///< fields and point_step, without points
  std::uint64_t points = 0;
  std::size_t offset = 0;
};

wire::FieldType type_of(const io::PcdColumn& c) {
  if (c.type == 'F') return c.size == 8 ? wire::FieldType::kFloat64 : wire::FieldType::kFloat32;
  const bool with_sign = c.type == 'I';
  if (c.size == 1) return with_sign ? wire::FieldType::kInt8 : wire::FieldType::kUint8;
  if (c.size == 2) return with_sign ? wire::FieldType::kInt16 : wire::FieldType::kUint16;
  return with_sign ? wire::FieldType::kInt32 : wire::FieldType::kUint32;
}

std::optional<Layout> layout_of(const io::PcdHeader& header) {
  if (header.encoding != io::PcdEncoding::kBinary || header.point_step == 0) return std::nullopt;
  Layout out;
  std::uint32_t offset = 0;
  for (const io::PcdColumn& c : header.columns) {
    if (c.size == 8 && c.type != 'F') return std::nullopt;  // PointCloud2 has no such type
    if (c.name != "_") out.shape.fields.push_back({c.name, offset, type_of(c), c.count});
    offset += c.size * c.count;
  }
  out.shape.point_step = static_cast<std::uint32_t>(header.point_step);
  out.points = header.points;
  out.offset = header.data_offset;
  return out;
}

std::optional<Layout> layout_of(const io::PlyHeader& header) {
  if (header.encoding != io::PlyEncoding::kBinaryLittle || header.elements.empty()) {
    return std::nullopt;
  }
  const io::PlyElement& vertices = header.elements.front();
  const std::uint64_t step = vertices.fixed_bytes();
  if (vertices.name != "vertex" || vertices.has_lists() || step == 0 || step > kChunkBytes) {
    return std::nullopt;
  }
  Layout out;
  std::uint32_t offset = 0;
  for (const io::PlyProperty& p : vertices.properties) {
    out.shape.fields.push_back({p.name, offset, p.type, 1});
    offset += io::field_bytes(p.type);
  }
  out.shape.point_step = static_cast<std::uint32_t>(step);
  out.points = vertices.count;
  out.offset = header.data_offset;
  return out;
}

Result<std::optional<Layout>> layout_of(std::span<const std::byte> head, const std::string& path) {
  if (io::begins_ply(head)) {
    const auto header = io::parse_ply_header(head, path);
    if (!header) return tl::make_unexpected(header.error());
    return layout_of(*header);
  }
  const auto header = io::parse_pcd_header(head, path);
  if (!header) return tl::make_unexpected(header.error());
  return layout_of(*header);
}

/// Values of the field `name` or `other`; empty if the cloud has neither.
std::vector<double> column(const io::CloudFile& cloud, const char* name, const char* other) {
  int field = cloud.field(name);
  if (field < 0) field = cloud.field(other);
  return field < 0 ? std::vector<double>() : cloud.column(field);
}

/// Selects points of parts of a cloud, in the order of the file.
class Thinner {
 public:
  Thinner(std::uint64_t points, std::size_t points_max) {
    if (points <= points_max) return;
    const double fraction = static_cast<double>(points_max) / static_cast<double>(points);
    limit_ = static_cast<std::uint64_t>(fraction * 18446744073709549568.0);
  }

  void take(const io::CloudFile& part) {
    const std::vector<double> x = column(part, "x", "x"), y = column(part, "y", "y"),
                              z = column(part, "z", "z"),
                              sigma = column(part, "sigma", "scalar_sigma"),
                              vehicle = column(part, "vehicle", "scalar_vehicle");
    for (std::size_t i = 0; i < std::min({x.size(), y.size(), z.size()}); ++i) {
      if (mixed(next_++) > limit_) continue;
      points_.x_m.push_back(static_cast<float>(x[i]));
      points_.y_m.push_back(static_cast<float>(y[i]));
      points_.z_m.push_back(static_cast<float>(z[i]));
      points_.sigma_m.push_back(sigma.empty() ? std::numeric_limits<float>::quiet_NaN()
                                              : static_cast<float>(sigma[i]));
      const double v = vehicle.empty() ? 0.0 : vehicle[i];
      points_.vehicle.push_back(v >= 0.0 && v < 255.5 ? static_cast<std::uint8_t>(v)
                                                      : std::uint8_t{0});
    }
  }

  [[nodiscard]] MapPoints points() && { return std::move(points_); }

 private:
  MapPoints points_;
  std::uint64_t limit_ = std::numeric_limits<std::uint64_t>::max(), next_ = 0;
};

Result<ThinnedMap> read_whole(const std::string& path, std::uint64_t bytes,
                              std::size_t points_max) {
  if (bytes > kWholeBytesMax) {
    return fail(ErrorCode::kInput, path,
                "is text or compressed and larger than 256 MiB: it cannot be read in parts",
                "Convert it: rali convert IN map.pcd.");
  }
  const Result<io::CloudFile> cloud = io::read_cloud_file(path);
  if (!cloud) return tl::make_unexpected(cloud.error());
  ThinnedMap out;
  out.points_in_file = cloud->size();
  Thinner thinner(out.points_in_file, points_max);
  thinner.take(*cloud);
  out.points = std::move(thinner).points();
  return out;
}

/// Fills `buffer` unless the file ends before. @return number of bytes read
Result<std::size_t> fill(io::InputFile& file, std::span<std::byte> buffer) {
  std::size_t have = 0;
  while (have < buffer.size()) {
    const Result<std::size_t> n = file.read(buffer.subspan(have));
    if (!n) return tl::make_unexpected(n.error());
    if (*n == 0) break;
    have += *n;
  }
  return have;
}

Result<ThinnedMap> read_parts(io::InputFile& file, Layout layout, std::vector<std::byte> pending,
                              std::size_t points_max) {
  const std::size_t step = layout.shape.point_step;
  const std::uint64_t there = std::min(
      layout.points, (file.size() - std::min<std::uint64_t>(layout.offset, file.size())) / step);
  ThinnedMap out;
  out.points_in_file = there;
  Thinner thinner(there, points_max);
  const std::size_t chunk = std::max(kChunkBytes / step, std::size_t{1}) * step;
  std::uint64_t read = 0;
  while (read < there) {
    // The bytes already read with the header come first.
    std::vector<std::byte> bytes = std::move(pending);
    pending = {};
    const std::size_t had = bytes.size();
    bytes.resize(std::max(chunk, (had + step - 1) / step * step));
    const Result<std::size_t> more = fill(file, std::span(bytes).subspan(had));
    if (!more) return tl::make_unexpected(more.error());
    const std::uint64_t n = std::min<std::uint64_t>((had + *more) / step, there - read);
    if (n == 0) break;
    layout.shape.width = static_cast<std::uint32_t>(n);
    layout.shape.data = std::move(bytes);
    thinner.take(layout.shape);
    read += n;
  }
  if (read < layout.points) {
    out.note = fmt::format("is cut: {} of {} points are there", read, layout.points);
  }
  out.points = std::move(thinner).points();
  return out;
}

}  // namespace

std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

Result<ThinnedMap> read_thinned_map(const std::string& path, std::size_t points_max) {
  Result<io::InputFile> file = io::InputFile::open(path);
  if (!file) return tl::make_unexpected(file.error());
  std::vector<std::byte> head(kHeadBytes);
  const Result<std::size_t> have = fill(*file, head);
  if (!have) return tl::make_unexpected(have.error());
  head.resize(*have);
  const auto layout = layout_of(head, path);
  if (!layout) return tl::make_unexpected(layout.error());
  if (!*layout) return read_whole(path, file->size(), points_max);
  head.erase(head.begin(),
             head.begin() + static_cast<std::ptrdiff_t>(std::min((*layout)->offset, head.size())));
  return read_parts(*file, std::move(**layout), std::move(head), points_max);
}

}  // namespace rali::report
