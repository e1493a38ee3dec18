#pragma once

#include "rali/inspect/recording_reading.hpp"

namespace rali::inspect {

/// Reads a folder of scans and its inertial data into an Examination.
/// Errors: kInput as in rali map: wrong stamps, no readable cloud.
[[nodiscard]] Result<ReadingEnd> read_scan_folder(const DoctorOptions& options,
                                                  Examination& examination, DoctorReport& report);

}  // namespace rali::inspect
