#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/io/files/cloud_file.hpp"

namespace rali::io {

/// Content of a cloud that a file format cannot hold, one sentence each.
using LostParts = std::vector<std::string>;

/// Any cloud as PCD, binary: all fields with their types.
[[nodiscard]] Result<LostParts> write_cloud_pcd(const std::string& path, const CloudFile& cloud);

/// Any cloud as PLY, binary little endian. Fields that PLY has no common name for are
/// `scalar_NAME`, which CloudCompare takes as scalar fields.
[[nodiscard]] Result<LostParts> write_cloud_ply(const std::string& path, const CloudFile& cloud);

/// Any cloud as LAS 1.4 (write_map_las): x y z intensity, and sigma, seen and vehicle of a map.
[[nodiscard]] Result<LostParts> write_cloud_las(const std::string& path, const CloudFile& cloud);

/// Any cloud as KITTI .bin: x y z intensity, float32.
[[nodiscard]] Result<LostParts> write_cloud_kitti(const std::string& path, const CloudFile& cloud);

}  // namespace rali::io
