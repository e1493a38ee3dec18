#pragma once

#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::drive {

/// What a log must be, for a remedy.
inline constexpr const char* kSerialLogFormat =
    "Record rows of `stamp_s,hex`: when bytes arrived, and the bytes in hexadecimal.";

/// Ranges of one log, in the order of its frames, and what was odd about it.
struct SerialRanges {
  std::vector<sensor::RangeSample> samples;
  std::uint64_t zeros = 0;  ///< distances of 0: none
  FindingList findings;
};

/// Reads the bytes of a LinkTrack radio's serial port: a CSV of `stamp_s,hex`, one row per read of
/// the port with its arrival and the bytes in hexadecimal (blanks between them or not). Frames may
/// be cut anywhere by the rows. Stamps: the radio's own clock brought to the host's by the lower
/// envelope of the arrivals (RadioStamps), or the arrivals alone (RangeStamp::kRecord); the latency
/// is not taken off. Memory does not grow with the log but for its ranges.
/// Errors: kInput with file and line (no such table, a row that is neither, no frame at all).
[[nodiscard]] Result<SerialRanges> read_serial_log(const SerialLog& log,
                                                   const RangeOptions& options);

}  // namespace rali::drive
