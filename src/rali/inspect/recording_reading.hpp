#pragma once

#include "rali/base/result.hpp"
#include "rali/inspect/doctor.hpp"
#include "rali/inspect/examination.hpp"
#include "rali/inspect/range_study.hpp"

namespace rali::inspect {

/// Result of reading an input.
struct ReadingEnd {
  double data_s = 0.0;         ///< of data examined
  double fraction_read = 1.0;  ///< of the file
  double rest_s = 0.0;         ///< of data after it, if an index shows it
};

/// Reads a recording of messages into an Examination and its ranges into `ranges`, in order of time
/// (drive::open_in_order). Topics, frames, extrinsics and damage go to `report`.
/// Errors: kInput if the file cannot be read at all.
[[nodiscard]] Result<ReadingEnd> read_recording(const DoctorOptions& options,
                                                Examination& examination, RangeStudy& ranges,
                                                DoctorReport& report);

}  // namespace rali::inspect
