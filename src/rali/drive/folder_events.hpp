#pragma once

#include <memory>
#include <string>

#include "rali/base/result.hpp"
#include "rali/drive/reported_source.hpp"

namespace rali::drive {

/// Events of one vehicle from a folder of scans (*.pcd, *.ply, *.bin, times.txt, imu.csv).
/// @param imu_file instead of imu.csv in the folder; empty: imu.csv, if it exists
/// Errors (kInput): no folder or scans, clouds without x y z, an imu.csv that does not fit.
[[nodiscard]] Result<std::unique_ptr<ReportedSource>> open_folder_events(
    const std::string& folder, const std::string& imu_file, const InputOptions& options);

}  // namespace rali::drive
