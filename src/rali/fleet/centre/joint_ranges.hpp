#pragma once

#include <compare>
#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// An antenna of the fleet; vehicles by their index in the list of paths.
struct Antenna {
  std::size_t path = 0;
  std::uint8_t number = 0;
  constexpr auto operator<=>(const Antenna&) const = default;
};

/// Two antennas that measure ranges to each other; each pair has its own bias. a < b.
struct AntennaPair {
  Antenna a, b;
  constexpr auto operator<=>(const AntennaPair&) const = default;
};

/// One end of a range: position of its antenna in the odom of its vehicle.
struct RangeEnd {
  PathPlace place;
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  bool at_rest = false;
  std::optional<geometry::Vec3> v_odom_mps;  ///< of the body, where inertial data determine it
  double speed_sigma_mps = 0.0;              ///< along the line of sight, about
};

/// One range measurement, once, with the data of both ends.
struct JointRange {
  Time t;
  int pair = 0;  ///< index in JointRanges::pairs
  RangeEnd a, b;
  double range_m = 0.0;
  double sigma_m = 0.0;  ///< the larger of the two ends' values
  bool blocked = false;  ///< the maps have a wall between the ends
};

struct JointRanges {
  std::vector<AntennaPair> pairs;  ///< ascending
  std::vector<JointRange> ranges;  ///< by time, then pair
  std::size_t without_pose = 0;    ///< time before or after the path of an end
};

/// Merges the reports of the two ends of each range measurement. If only one end reported, the
/// other end is interpolated on its path. Repeated values of a frozen radio are dropped if its ends
/// move.
/// @param since those of earlier times are left out
[[nodiscard]] JointRanges join_ranges(std::span<const VehiclePath> paths,
                                      std::optional<Time> since = std::nullopt);

}  // namespace rali::fleet
