#include "rali/io/files/cloud_writers.hpp"

#include <fmt/core.h>

#include "rali/base/assert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/record.hpp"

namespace rali::io {
namespace {

// Points are written in batches of this size, to limit memory.
constexpr std::size_t kLot = 4096;

std::string pcd_header(const char* columns, std::uint64_t points) {
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n{}WIDTH {}\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      columns, points, points);
}

void check_lengths(const MapColumns& c) {
  RALI_ASSERT(c.y_m.size() == c.size() && c.z_m.size() == c.size());
  RALI_ASSERT(c.intensity.size() == c.size() && c.sigma_m.size() == c.size());
  RALI_ASSERT(c.seen.size() == c.size() && c.vehicle.size() == c.size());
}

/// Header, then all parts as records of 23 bytes: the same for PCD and PLY.
Status write_map(const std::string& path, const std::string& header, std::uint64_t points,
                 const MapParts& parts) {
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  if (auto status = file->write(std::string_view(header)); !status) return status;
  std::uint64_t written = 0;
  Record lot;
  MapColumns c;
  while (true) {
    const auto more = parts(c);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    check_lengths(c);
    for (std::size_t i = 0; i < c.size(); ++i) {
      lot.put(c.x_m[i]).put(c.y_m[i]).put(c.z_m[i]).put(c.intensity[i]).put(c.sigma_m[i]);
      lot.put(c.seen[i]).put(c.vehicle[i]);
      if ((i + 1) % kLot != 0 && i + 1 != c.size()) continue;
      if (auto status = file->write(lot.bytes()); !status) return status;
      lot.clear();
    }
    written += c.size();
  }
  RALI_ASSERT(written == points);
  return file->commit();
}

}  // namespace

MapParts one_part(const MapColumns& columns) {
  return [columns, given = false](MapColumns& out) mutable -> Result<bool> {
    if (given) return false;
    given = true;
    out = columns;
    return true;
  };
}

Status write_map_pcd(const std::string& path, std::uint64_t points, const MapParts& parts) {
  constexpr const char* kColumns =
      "FIELDS x y z intensity sigma seen vehicle\nSIZE 4 4 4 4 4 2 1\nTYPE F F F F F U U\n"
      "COUNT 1 1 1 1 1 1 1\n";
  return write_map(path, pcd_header(kColumns, points), points, parts);
}

Status write_map_ply(const std::string& path, std::uint64_t points, const MapParts& parts) {
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment frame map, metres; sigma: expected position "
      "error; seen: keyframes that saw it\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty float intensity\nproperty float scalar_sigma\n"
      "property ushort scalar_seen\nproperty uchar scalar_vehicle\nend_header\n",
      points);
  return write_map(path, header, points, parts);
}

Status write_keyframe_pcd(const std::string& path, const KeyframeColumns& c) {
  RALI_ASSERT(c.y_m.size() == c.size() && c.z_m.size() == c.size());
  RALI_ASSERT(c.intensity.size() == c.size());
  RALI_ASSERT(c.ring.empty() || c.ring.size() == c.size());
  auto file = AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  constexpr const char* kColumns =
      "FIELDS x y z intensity ring\nSIZE 4 4 4 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\n";
  const std::string header = pcd_header(kColumns, c.size());
  if (auto status = file->write(std::string_view(header)); !status) return status;
  Record lot;
  for (std::size_t i = 0; i < c.size(); ++i) {
    lot.put(c.x_m[i]).put(c.y_m[i]).put(c.z_m[i]).put(c.intensity[i]);
    lot.put(c.ring.empty() ? std::uint16_t{0} : c.ring[i]);
    if ((i + 1) % kLot != 0 && i + 1 != c.size()) continue;
    if (auto status = file->write(lot.bytes()); !status) return status;
    lot.clear();
  }
  return file->commit();
}

}  // namespace rali::io
