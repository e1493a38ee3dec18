#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::drive {

/// A pose by LiDAR and inertial data alone, on the clock of its vehicle.
struct ClockPose {
  Time t;
  geometry::SE3 T_odom_body;
  std::uint32_t piece = 0;  ///< a new one starts after each loss of tracking
  bool degenerate = false;  ///< the speed is that of the inertial data
};

/// What one vehicle's data tell about its clock.
struct ClockEvidence {
  std::vector<ClockPose> poses;
  std::vector<geometry::Vec3> antennas_body_m;
  bool known = false;  ///< the stamps already are on the clock of the fleet
};

/// Ranges stamped by one vehicle's clock.
struct ClockedRanges {
  VehicleId clock;
  std::vector<sensor::RangeSample> samples;  ///< by time
};

/// Estimates what must be added to each vehicle's stamps to get those of the fleet, which are the
/// first vehicle's: from the ranges of a vehicle that moves to one that stands, stamped by another
/// clock than its own. The latency of the ranges is estimated too, from ranges that a moving
/// vehicle has stamped itself.
/// @param latency_known it is already subtracted from the stamps
/// @return one per vehicle; without a sigma, and with the reason, where it is not certain
[[nodiscard]] std::vector<ClockOffset> judge_clock_offsets(std::span<const ClockEvidence> vehicles,
                                                           std::span<const ClockedRanges> ranges,
                                                           bool latency_known);

/// How far apart clocks may be to be found [s].
inline constexpr double kClockSearch_s = 10.0;
inline constexpr double kClockSigmaMax_s = 0.05;

}  // namespace rali::drive
