#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::io {

enum class CloudFileKind { kPcd, kPly, kKitti, kLas };

/// A point cloud of a file in the layout of a PointCloud2: whole points in rows
/// of point_step bytes, little endian. Owns its bytes.
struct CloudFile {
  CloudFileKind kind = CloudFileKind::kPcd;
  std::string encoding;  ///< "ascii", "binary", "binary_compressed", "binary_big_endian", ...
  std::uint32_t width = 0, height = 1;  ///< height > 1: organised, row after row
  std::uint32_t point_step = 0;         ///< bytes of one point
  std::vector<wire::CloudField> fields;
  std::vector<std::byte> data;
  /// VIEWPOINT of a PCD that is not the identity. Programs interpret it differently; the points are
  /// not transformed.
  std::optional<geometry::SE3> viewpoint;
  FindingList findings;

  [[nodiscard]] std::size_t size() const { return std::size_t{width} * height; }

  /// Index of a field by its exact name, -1 if there is none.
  [[nodiscard]] int field(std::string_view name) const;

  /// Element 0 of a field for all points, as doubles. `field_index` must be a valid index.
  [[nodiscard]] std::vector<double> column(int field_index) const;

  /// View of this object's points; the object must outlive it.
  [[nodiscard]] wire::CloudView view(Time stamp, std::string frame_id) const;
};

/// Layout of a KITTI .bin, which has no header.
enum class KittiLayout {
  kAuto,          ///< by value: x y z intensity, or an error that describes the content
  kXyzIntensity,  ///< four float32
  kXyz            ///< three float32
};

struct CloudFileOptions {
  KittiLayout kitti = KittiLayout::kAuto;
};

/// Clouds above this size are refused: offsets within a PointCloud2 are 32 bits wide.
inline constexpr std::uint64_t kCloudBytesMax = 0xffff'ffffULL;

/// Reads a cloud; PCD, PLY and LAS are recognised by content, KITTI .bin by name. Errors: kInput,
/// with file and line or offset, for damage and for files that are no cloud. A KITTI .bin that ends
/// within a point is accepted with a finding.
[[nodiscard]] Result<CloudFile> read_cloud_file(const std::string& path,
                                                const CloudFileOptions& options = {});

/// The same from memory; `path` is for messages and, for KITTI, its extension.
[[nodiscard]] Result<CloudFile> parse_cloud_file(std::vector<std::byte> bytes,
                                                 const std::string& path,
                                                 const CloudFileOptions& options = {});

[[nodiscard]] Result<CloudFile> parse_pcd(std::vector<std::byte> bytes, const std::string& path);
[[nodiscard]] Result<CloudFile> parse_ply(std::vector<std::byte> bytes, const std::string& path);
[[nodiscard]] Result<CloudFile> parse_kitti(std::vector<std::byte> bytes, const std::string& path,
                                            KittiLayout layout);
/// LAS 1.0 to 1.4, not compressed: x y z (float64), intensity, classification, point_source and,
/// where the point format has it, gps_time; of extra dimensions only `sigma`.
[[nodiscard]] Result<CloudFile> parse_las(std::vector<std::byte> bytes, const std::string& path);

/// Bytes of one element of a field.
[[nodiscard]] std::uint32_t field_bytes(wire::FieldType type);

}  // namespace rali::io
