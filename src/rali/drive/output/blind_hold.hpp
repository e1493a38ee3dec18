#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What kept a pose in its least known direction.
enum class HeldBy : std::uint8_t { kLidar, kRange, kImu, kNothing };
inline constexpr std::array<std::string_view, 4> kHeldByNames{"lidar", "range", "imu", "nothing"};

/// Tells pose by pose what holds the vehicle: the LiDAR where it is not blind; else a range, until
/// 2 s after the last one that moved the pose (then the link counts as lost, algorithms 4.3);
/// else the inertial sensor, at rest or for 3 s (2.6: then the direction is lost); else nothing.
class BlindHold {
 public:
  [[nodiscard]] HeldBy see(const vehicle::PoseEstimate& pose, bool has_imu);

 private:
  std::optional<Time> t_range_;
  std::optional<Time> t_held_;  ///< the last pose held by LiDAR, range or rest
};

}  // namespace rali::drive
