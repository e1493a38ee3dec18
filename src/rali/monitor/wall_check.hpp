#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rali/monitor/contradiction.hpp"
#include "rali/monitor/settings.hpp"

namespace rali::monitor {

/// How one keyframe's rays agree with the walls of the map, which all keyframes have made.
struct WallSight {
  Time t;
  std::size_t looks = 0;        ///< places on walls of which its rays say something
  std::size_t passes = 0;       ///< of these, that a ray went through
  std::size_t made = 0;         ///< places on walls that it was the first to see
  std::size_t made_passed = 0;  ///< of these, that keyframes which look through walls went through
  /// As looks and passes, of walls that another vehicle was the first to see.
  std::size_t others_looks = 0, others_passes = 0;
};

/// A stretch of time in which a vehicle's scans look through walls of the map.
struct SeenThrough {
  Stretch when;
  double ratio = 0.0;      ///< largest, of passes to looks, or of passed to made
  bool looks = false;      ///< else others look through what it has made
  bool of_others = false;  ///< it looks through walls that other vehicles have made
};

/// A wall that was seen from elsewhere and is not there from here means that one of the two poses
/// is wrong, and not which: who looks through walls is named, and who has made them. The check
/// shares nothing with the estimator but the poses. Walls of other vehicles count apart: a corridor
/// laid across one's own at a wrong angle is little beside all that is in view. A single keyframe
/// counts; those of one stretch are at most 5 s apart.
/// @param sights  of one vehicle, by time
[[nodiscard]] std::vector<SeenThrough> check_walls(std::span<const WallSight> sights,
                                                   const MonitorSettings& settings);

/// Whether any keyframe looks through walls. Without one nobody who has made walls is to be named:
/// what few looks went through (people, edges) contradicts nothing.
[[nodiscard]] bool looks_through(std::span<const WallSight> sights,
                                 const MonitorSettings& settings);

/// The settings to judge a map by: walls of other vehicles count where at least two vehicles look
/// through them. Of two corridors laid across each other both do; through what has driven away
/// since the other saw it, only one does.
/// @param vehicles  sights of each
[[nodiscard]] MonitorSettings settings_for(std::span<const std::vector<WallSight>> vehicles,
                                           const MonitorSettings& settings);

/// How many keyframes see enough walls to be judged.
[[nodiscard]] std::size_t judged(std::span<const WallSight> sights,
                                 const MonitorSettings& settings);

}  // namespace rali::monitor
