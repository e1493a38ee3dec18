#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// The sensor that constrained a pose in its least observable direction.
enum class HeldBy : std::uint8_t { kLidar, kRange, kImu, kNothing };
inline constexpr std::array<std::string_view, 4> kHeldByNames{"lidar", "range", "imu", "nothing"};

/// Determines for each pose what constrains the vehicle: the LiDAR unless it is degenerate; else a
/// range, until 2 s after the last one that moved the pose (then the link counts as lost,
/// algorithms 4.3); else the inertial sensor, at standstill or for 3 s (2.6: then the direction is
/// lost); else nothing.
class DegenerateHold {
 public:
  [[nodiscard]] HeldBy see(const vehicle::PoseEstimate& pose, bool has_imu);

 private:
  std::optional<Time> t_range_;
  std::optional<Time> t_held_;  ///< the last pose constrained by LiDAR, range or standstill
};

}  // namespace rali::drive
