#pragma once

#include <memory>

#include "rali/drive/map_run.hpp"
#include "rali/drive/reported_source.hpp"

namespace rali::drive {

/// The source that fits a vehicle's inputs: a folder of scans, or recordings in a row.
/// Errors: kUsage, kInput.
[[nodiscard]] Result<std::unique_ptr<ReportedSource>> open_events(const VehicleJob& job);

}  // namespace rali::drive
