#pragma once

#include <functional>

#include "rali/base/executor.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/drive/offset/clock_offset.hpp"

namespace rali::drive {

/// Plays one vehicle's whole input through its odometry, without ranges.
struct ClockPass {
  ClockEvidence evidence;
  std::vector<sensor::RangeSample> ranges;  ///< of the topics of its recordings
};

/// @param job its input.clock_offset is added to the stamps
/// @param go_on receives the fraction of the data processed (0..1); false ends the pass early
/// Unreadable data end it, too; the run itself reports them.
[[nodiscard]] ClockPass play_for_clock(const VehicleJob& job, Executor& executor, bool read_ahead,
                                       const std::function<bool(double fraction)>& go_on);

/// D17 of `rali map`, clock: offset: what is added to one vehicle's stamps, or that it is not
/// known.
[[nodiscard]] Finding clock_offset_finding(const std::string& vehicle, const std::string& reference,
                                           const ClockOffset& offset);

/// D17 of `rali map`, clock: synchronised: a clock that differs, by the result of a run. Empty if
/// none does, or if it is not certain.
[[nodiscard]] std::optional<Finding> other_clock_finding(const std::string& vehicle,
                                                         const std::string& reference,
                                                         const ClockOffset& offset);

}  // namespace rali::drive
