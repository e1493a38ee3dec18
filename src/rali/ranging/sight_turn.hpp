#pragma once

#include <deque>
#include <utility>

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::ranging {

/// How much the line of sight between two antennas has turned while the last ranges came, on whose
/// median the ExcessWatch relies. Past an antenna it turns fast, and there an error of the pose
/// changes the predicted distance from one range to the next.
class SightTurn {
 public:
  /// @param sight unit vector along the line  @return its change since the oldest one in memory
  geometry::Vec3 add(Time t, const geometry::Vec3& sight) {
    constexpr double kMemory_s = 5.0;  // the oldest level of the watch
    sights_.emplace_back(t, sight);
    while (seconds_between(sights_.front().first, t) > kMemory_s) sights_.pop_front();
    return sight - sights_.front().second;
  }

 private:
  std::deque<std::pair<Time, geometry::Vec3>> sights_;
};

}  // namespace rali::ranging
