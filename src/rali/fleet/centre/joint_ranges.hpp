#pragma once

#include <compare>
#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// An antenna of the fleet; vehicles by their place in the list of paths.
struct Antenna {
  std::size_t path = 0;
  std::uint8_t number = 0;
  constexpr auto operator<=>(const Antenna&) const = default;
};

/// Two antennas that measure ranges to each other; the bias is theirs. a < b.
struct AntennaPair {
  Antenna a, b;
  constexpr auto operator<=>(const AntennaPair&) const = default;
};

/// One end of a range: where its antenna was in the odom of its vehicle.
struct RangeEnd {
  PathPlace place;
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  bool at_rest = false;
};

/// One exchange of radio waves, once, with what both ends know of it.
struct JointRange {
  Time t;
  int pair = 0;  ///< index in JointRanges::pairs
  RangeEnd a, b;
  double range_m = 0.0;
  double sigma_m = 0.0;  ///< the larger of what the two ends say
  bool blocked = false;  ///< the maps have a wall in between
};

struct JointRanges {
  std::vector<AntennaPair> pairs;  ///< ascending
  std::vector<JointRange> ranges;  ///< by time, then pair
  std::size_t without_pose = 0;    ///< an end was not yet, or no longer, on its path
};

/// Without what a frozen radio repeats while its ends move on. Brings together what the two ends of
/// each exchange reported. An exchange that only one end reported is placed at the other end by the
/// path between its nodes.
/// @param since those of earlier times are left out
[[nodiscard]] JointRanges join_ranges(std::span<const VehiclePath> paths,
                                      std::optional<Time> since = std::nullopt);

}  // namespace rali::fleet
