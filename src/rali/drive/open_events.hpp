#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/drive/map_run.hpp"
#include "rali/drive/reported_source.hpp"

namespace rali::drive {

/// True if a vehicle's data is a folder of scans, false if it is a sequence of recordings.
/// @param imu_file CSV of inertial data beside a folder of scans, empty if not given
/// Errors: kUsage (a mixture; inertial data given beside a recording), kInput.
[[nodiscard]] Result<bool> is_scan_folder(const std::vector<std::string>& inputs,
                                          const std::string& imu_file);

/// The source for a vehicle's inputs: a folder of scans, or a sequence of recordings.
/// Errors: kUsage, kInput.
[[nodiscard]] Result<std::unique_ptr<ReportedSource>> open_events(const VehicleJob& job);

}  // namespace rali::drive
