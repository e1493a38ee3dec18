#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/ranging/range_use.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::drive {

/// The ranges of all CSV files of a job.
struct RangeList {
  std::vector<sensor::RangeSample> samples;        ///< by time; at one time by file and row
  std::map<std::uint16_t, std::string> strangers;  ///< names that are no vehicle, by their number
  FindingList findings;
};

/// Reads the CSV files and serial logs, subtracts the latency from the stamps and sorts all ranges.
/// Rows that name no vehicle of the fleet stay as ranges of strangers.
/// @param clock_offsets_s of each vehicle, added to the stamps that its clock has made; empty: none
/// Errors: kInput (no file, a column missing, no valid row).
[[nodiscard]] Result<RangeList> read_range_files(const RangeOptions& options,
                                                 std::span<const double> clock_offsets_s = {});

/// Checks a range without any pose: unknown antenna, or impossible length.
/// @return kNoPose for a range that the vehicles have to judge
[[nodiscard]] ranging::RangeReason judge_range(const sensor::RangeSample& sample,
                                               const RangeOptions& options);

}  // namespace rali::drive
