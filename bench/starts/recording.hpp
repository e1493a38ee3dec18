#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::bench {

/// A scan and its pose in a reference trajectory.
struct ReferencedScan {
  std::shared_ptr<const sensor::LidarScan> scan;
  geometry::SE3 T_map_lidar;
};

using ReferencedScans = std::vector<ReferencedScan>;

/// Compact scans (FOLDER/scans/NNNNNN.xyzi) and FOLDER/poses.tum, one line per scan.
/// Errors (kInput): a file is missing.
[[nodiscard]] Result<ReferencedScans> read_compact_scans(const std::string& folder);

/// The same scans in reversed time.
[[nodiscard]] ReferencedScans reversed(const ReferencedScans& scans);

/// Every second scan, from the first.
[[nodiscard]] ReferencedScans halved(const ReferencedScans& scans);

}  // namespace rali::bench
