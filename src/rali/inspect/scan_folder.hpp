#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::inspect {

/// Files of a folder of clouds (pcd, ply, bin) in natural order.
struct ScanFolder {
  std::vector<std::string> clouds;  ///< paths
  std::string times_file;           ///< times.txt, empty if there is none
  std::string imu_file;             ///< imu.csv, likewise
};

/// Empty list of clouds if the path is no folder, or one of a recording (db3, mcap, bag).
/// Errors: kInput if the folder cannot be read.
[[nodiscard]] Result<ScanFolder> look_for_scans(const std::string& path);

}  // namespace rali::inspect
