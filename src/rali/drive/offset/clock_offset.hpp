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
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// A pose by LiDAR and inertial data alone, on the clock of its vehicle.
struct ClockPose {
  Time t;
  geometry::SE3 T_odom_body;
  std::uint32_t piece = 0;  ///< a new one starts after each loss of tracking
  bool degenerate = false;  ///< the speed is that of the inertial data
};

/// What is known of one vehicle's clock: its motion on it.
struct ClockEvidence {
  /// The next pose by time. A lost one is left out, and a new piece starts.
  void add(Time t, const geometry::SE3& T_odom_body, vehicle::PoseQuality quality, bool degenerate);

  std::vector<ClockPose> poses;
  std::vector<geometry::Vec3> antennas_body_m;
  bool known = false;       ///< the stamps already are on the clock of the fleet
  std::uint32_t piece = 0;  ///< of the next pose
};

/// How much is looked at.
struct ClockSearch {
  double half_s = 10.0;          ///< how far apart clocks may be to be found
  std::size_t windows_max = 24;  ///< stretches per clock and moving vehicle
  std::size_t ranges_max = 300;  ///< per stretch
  bool latency_known = false;    ///< it is already subtracted from the stamps
};

/// Estimates what must be added to each vehicle's stamps to get those of the fleet, which are the
/// first vehicle's: from the ranges of a vehicle that moves to one that stands, stamped by another
/// clock than its own. The latency of the ranges is estimated too, from ranges that a moving
/// vehicle has stamped itself.
/// @param ranges in any order
/// @return one per vehicle; without a sigma, and with the reason, where it is not certain
[[nodiscard]] std::vector<ClockOffset> judge_clock_offsets(
    std::span<const ClockEvidence> vehicles, std::span<const sensor::RangeSample> ranges,
    const ClockSearch& search);

inline constexpr double kClockSigmaMax_s = 0.05;

}  // namespace rali::drive
