#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rali/monitor/contradiction.hpp"
#include "rali/monitor/settings.hpp"

namespace rali::monitor {

/// Agreement of one keyframe's rays with the walls of the map, which all keyframes have made.
struct WallSight {
  Time t;
  std::size_t looks = 0;        ///< places on walls that its rays hit or passed
  std::size_t passes = 0;       ///< of these, those that a ray passed
  std::size_t made = 0;         ///< places on walls that it saw first
  std::size_t made_passed = 0;  ///< of these, those passed by keyframes whose rays pass walls
  /// As looks and passes, for walls that another vehicle saw first.
  std::size_t others_looks = 0, others_passes = 0;
};

/// A time interval in which rays of a vehicle's scans pass walls of the map.
struct SeenThrough {
  Stretch when;
  double ratio = 0.0;      ///< largest, of passes to looks, or of made_passed to made
  bool looks = false;      ///< else others' rays pass walls that it saw first
  bool of_others = false;  ///< its rays pass walls that other vehicles saw first
};

/// If rays pass a wall that was seen from elsewhere, one of the two poses is wrong, and it is
/// unknown which. So both are reported: keyframes whose rays pass walls, and those that saw these
/// walls first. Apart from the poses, the check is independent of the estimator. Walls of other
/// vehicles count apart: a corridor placed across one's own at a wrong angle is a small part of all
/// in view. A single keyframe suffices if it is twice beyond a limit; those of one interval are at
/// most 5 s apart.
/// @param sights  of one vehicle, by time
[[nodiscard]] std::vector<SeenThrough> check_walls(std::span<const WallSight> lines_of_sight,
                                                   const MonitorSettings& settings);

/// Whether rays of any keyframe pass walls. Otherwise no keyframe that saw walls first is to be
/// reported: the few passes (people, edges) contradict nothing.
[[nodiscard]] bool looks_through(std::span<const WallSight> lines_of_sight,
                                 const MonitorSettings& settings);

/// The settings for a map's check: walls of other vehicles count only if rays of at least two
/// vehicles pass them. Of two corridors placed across each other both do; through an object that
/// has left since the other vehicle saw it, only one does.
/// @param vehicles  sights of each
[[nodiscard]] MonitorSettings settings_for(std::span<const std::vector<WallSight>> vehicles,
                                           const MonitorSettings& settings);

/// Number of keyframes with enough walls in view for the check.
[[nodiscard]] std::size_t judged(std::span<const WallSight> lines_of_sight,
                                 const MonitorSettings& settings);

}  // namespace rali::monitor
