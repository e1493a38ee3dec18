#pragma once

#include "rali/inspect/recording_reading.hpp"

namespace rali::inspect {

/// Reads a folder of scans and its inertial data into an Examination.
/// Errors: kInput for what rali map refuses: stamps that do not fit, no cloud that can be read.
[[nodiscard]] Result<ReadingEnd> read_scan_folder(const DoctorOptions& options,
                                                  Examination& examination, DoctorReport& report);

}  // namespace rali::inspect
