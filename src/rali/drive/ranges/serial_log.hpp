#pragma once

#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::drive {

/// Required format of a log, for a remedy.
inline constexpr const char* kSerialLogFormat =
    "Record rows of `stamp_s,hex`: when bytes arrived, and the bytes in hexadecimal.";

/// Ranges of one log, in the order of its frames, and findings about irregularities.
struct SerialRanges {
  std::vector<sensor::RangeSample> samples;
  std::uint64_t zeros = 0;  ///< distances of 0: no measurement
  FindingList findings;
};

/// Reads the bytes of a LinkTrack radio's serial port: a CSV of `stamp_s,hex`, one row per read of
/// the port with its arrival and the bytes in hexadecimal (with or without blanks between them).
/// Rows may cut frames anywhere. Stamps: the radio's own clock mapped to the host's by the lower
/// envelope of the arrivals (RadioStamps), or the arrivals alone (RangeStamp::kRecord); the latency
/// is not subtracted. Memory grows with the number of ranges only.
/// Errors: kInput with file and line (no such table, an invalid row, no frame at all).
[[nodiscard]] Result<SerialRanges> read_serial_log(const SerialLog& log,
                                                   const RangeOptions& options);

}  // namespace rali::drive
