#include <algorithm>
#include <cstring>
#include <optional>

#include <fmt/core.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/ply_header.hpp"
#include "rali/io/files/record.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

template <class T>
double value_of(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double decode(const std::byte* little, wire::FieldType type) {
  switch (type) {
    case wire::FieldType::kInt8:
      return value_of<std::int8_t>(little);
    case wire::FieldType::kUint8:
      return value_of<std::uint8_t>(little);
    case wire::FieldType::kInt16:
      return value_of<std::int16_t>(little);
    case wire::FieldType::kUint16:
      return value_of<std::uint16_t>(little);
    case wire::FieldType::kInt32:
      return value_of<std::int32_t>(little);
    case wire::FieldType::kUint32:
      return value_of<std::uint32_t>(little);
    case wire::FieldType::kFloat32:
      return value_of<float>(little);
    case wire::FieldType::kFloat64:
      return value_of<double>(little);
  }
  return 0.0;
}

/// The numbers of a PLY body in sequence, text or binary.
class Numbers {
 public:
  Numbers(std::span<const std::byte> body, PlyEncoding encoding)
      : rest_(body), encoding_(encoding) {}

  std::optional<double> next(wire::FieldType type) {
    if (encoding_ == PlyEncoding::kAscii) return next_word();
    const std::size_t n = field_bytes(type);
    if (rest_.size() < n) return std::nullopt;
    std::byte raw[8];
    std::copy(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(n), raw);
    if (encoding_ == PlyEncoding::kBinaryBig) std::reverse(raw, raw + n);
    rest_ = rest_.subspan(n);
    return decode(raw, type);
  }

  /// Remaining bytes: each row takes at least one.
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::optional<double> next_word() {
    const auto blank = [](std::byte b) { return std::to_integer<int>(b) <= ' '; };
    const auto begin = std::find_if_not(rest_.begin(), rest_.end(), blank);
    const auto end = std::find_if(begin, rest_.end(), blank);
    const auto word = rest_.subspan(static_cast<std::size_t>(begin - rest_.begin()),
                                    static_cast<std::size_t>(end - begin));
    rest_ = rest_.subspan(static_cast<std::size_t>(end - rest_.begin()));
    return parse_number(as_text(word));
  }

  std::span<const std::byte> rest_;
  PlyEncoding encoding_;
};

/// Reads the rows of all elements, keeps vertices and faces.
class MeshRows {
 public:
  MeshRows(const PlyHeader& header, std::span<const std::byte> body, const std::string& path)
      : header_(header), numbers_(body, header.encoding), path_(path) {}

  Result<MeshFile> read() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;
      if (element.count > numbers_.left()) return cut(element, 0);
      for (std::uint64_t row = 0; row < element.count; ++row) {
        if (!read_row(element)) return cut(element, row);
        if (!wrong_.empty()) {
          return fail(ErrorCode::kInput, path_,
                      fmt::format("row {} of element {}: {}", row, quoted(element.name), wrong_));
        }
      }
    }
    if (mesh_.reflectivity.size() != mesh_.triangles.size()) mesh_.reflectivity.clear();
    return std::move(mesh_);
  }

 private:
  bool read_row(const PlyElement& element) {
    const bool vertex = element.name == "vertex";
    const bool face = element.name == "face";
    geometry::Vec3f p = geometry::Vec3f::Zero();
    const std::size_t triangles = mesh_.triangles.size();
    std::optional<float> reflectivity;
    for (const PlyProperty& property : element.properties) {
      if (property.list_count) {
        const bool corners = face && (property.name == "vertex_indices" ||  //
                                      property.name == "vertex_index");
        if (!read_list(property, corners)) return false;
        continue;
      }
      const auto value = numbers_.next(property.type);
      if (!value) return false;
      for (int axis = 0; axis < 3 && vertex; ++axis) {
        if (property.name.size() == 1 && property.name[0] == "xyz"[axis]) {
          p[axis] = static_cast<float>(*value);
        }
      }
      if (face && property.name == "reflectivity") reflectivity = static_cast<float>(*value);
    }
    if (vertex) mesh_.vertices.push_back(p);
    if (reflectivity) {
      mesh_.reflectivity.resize(triangles);
      mesh_.reflectivity.resize(mesh_.triangles.size(), *reflectivity);
    }
    return true;
  }

  bool read_list(const PlyProperty& property, bool corners) {
    const auto n = numbers_.next(*property.list_count);
    if (!n || !(*n >= 0.0) || *n > static_cast<double>(numbers_.left())) return false;
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(*n); ++i) {
      const auto value = numbers_.next(property.type);
      if (!value) return false;
      if (!corners) continue;
      if (!(*value >= 0.0 && *value < 4294967295.0)) {
        wrong_ = fmt::format("{} is no vertex", *value);
        return true;
      }
      const auto index = static_cast<std::uint32_t>(*value);
      if (i == 0) first = index;
      if (i >= 2) mesh_.triangles.push_back({first, last, index});
      last = index;
    }
    return true;
  }

  [[nodiscard]] tl::unexpected<Error> cut(const PlyElement& element, std::uint64_t row) const {
    return fail(ErrorCode::kInput, path_,
                fmt::format("is cut or no PLY: row {} of {} of element {} cannot be read", row,
                            element.count, quoted(element.name)));
  }

  const PlyHeader& header_;
  Numbers numbers_;
  const std::string& path_;
  std::string wrong_;
  MeshFile mesh_;
};

}  // namespace

Result<MeshFile> parse_mesh_ply(std::span<const std::byte> bytes, const std::string& path) {
  if (!as_text(bytes).starts_with("ply")) {
    return fail(ErrorCode::kInput, path, "does not begin with 'ply'");
  }
  const auto header = parse_ply_header(bytes, path);
  if (!header) return tl::make_unexpected(header.error());
  return MeshRows(*header, bytes.subspan(header->data_offset), path).read();
}

Status write_mesh_ply(const std::string& path, std::span<const geometry::Vec3f> vertices,
                      std::span<const std::array<std::uint32_t, 3>> triangles,
                      std::span<const float> reflectivity) {
  if (!reflectivity.empty() && reflectivity.size() != triangles.size()) {
    return fail(ErrorCode::kUsage, path, "has not one reflectivity per triangle");
  }
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nelement face {}\n"
      "property list uchar int vertex_indices\n{}end_header\n",
      vertices.size(), triangles.size(),
      reflectivity.empty() ? "" : "property float reflectivity\n");
  if (auto status = file->write(std::string_view(header)); !status) return status;
  constexpr std::size_t kLot = 1U << 16U;
  Record lot;
  for (const geometry::Vec3f& v : vertices) {
    lot.put(v.x()).put(v.y()).put(v.z());
    if (lot.size() < kLot) continue;
    if (auto status = file->write(lot.bytes()); !status) return status;
    lot.clear();
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    lot.put(std::uint8_t{3}).put(triangles[i][0]).put(triangles[i][1]).put(triangles[i][2]);
    if (!reflectivity.empty()) lot.put(reflectivity[i]);
    if (lot.size() < kLot) continue;
    if (auto status = file->write(lot.bytes()); !status) return status;
    lot.clear();
  }
  if (auto status = file->write(lot.bytes()); !status) return status;
  return file->commit();
}

}  // namespace rali::io
