#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/inspect/doctor.hpp"
#include "rali/ranging/stamp_offset.hpp"

namespace rali::inspect {

/// Fits ranges to the distances between a track and a stationary point, which is estimated too, for
/// latencies within 0.3 s. The track is that of the LiDAR: the antenna's lever arm changes the
/// distance only where the vehicle turns.
/// Empty where the latency is not observable: too few ranges, too short a trajectory, or a sigma
/// above 30 ms.
[[nodiscard]] std::optional<ranging::StampOffset> latency_by_motion(
    ranging::Track track, std::span<const std::pair<Time, double>> ranges);

/// D16: latency of the ranges of each pair with one vehicle at standstill, and whose clock stamps
/// them.
void report_latency(const std::vector<DoctorReport>& recordings, const RangeStudy& ranges,
                    FindingList& out);

/// D17: start of the vehicles' recordings, and the duration of their overlap.
/// @param separate recorded on different days, as fleet.yaml says
void report_overlap(const std::vector<DoctorReport>& recordings, bool separate, FindingList& out);

}  // namespace rali::inspect
