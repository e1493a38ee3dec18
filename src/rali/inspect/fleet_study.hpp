#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/inspect/doctor.hpp"

namespace rali::inspect {

/// Age of ranges at their stamps, as the motion of one vehicle past a standing one shows it.
struct LatencyByMotion {
  double latency_s = 0.0, sigma_s = 0.0;
  double residual_m = 0.0;  ///< root mean square of what is left
  std::size_t ranges = 0;
};

/// Compares ranges with the distances between a track and a point at rest, which is estimated with
/// them, for latencies within 0.3 s. The track is that of the LiDAR: an antenna beside it changes
/// the distance by its lever only where the vehicle turns.
/// Empty where the motion does not show it: too few ranges, too short a way, or a sigma above 30
/// ms.
[[nodiscard]] std::optional<LatencyByMotion> latency_by_motion(
    std::span<const drive::TrackPoint> track, std::span<const std::pair<Time, double>> ranges);

/// D16: latency of the ranges of each pair of which one stood, and whose clock stamps them.
void report_latency(const std::vector<DoctorReport>& recordings, const RangeStudy& ranges,
                    FindingList& out);

/// D17: when the vehicles' recordings begin, and how long they run together.
/// @param separate recorded on different days, as fleet.yaml says
void report_overlap(const std::vector<DoctorReport>& recordings, bool separate, FindingList& out);

}  // namespace rali::inspect
