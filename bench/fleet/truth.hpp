#pragma once

#include <optional>
#include <vector>

#include "join.hpp"

namespace rali::fleet_bench {

/// True pose of a vehicle at the last point of the scan that ended at t.
[[nodiscard]] std::optional<geometry::SE3> truth_at(const Mission& mission, VehicleId vehicle,
                                                    Time t);

/// Poses of one vehicle in the map, paired with ground truth; diverged ones are left out.
[[nodiscard]] eval::PairList pairs_of(const Driven& driven, const Path& path);

/// Error between two frames: T_ref^-1 T_est as a distance and an angle.
struct FrameError {
  double distance_m = 0.0;
  double angle_rad = 0.0;
};

/// Error of the pose of vehicle `b` relative to vehicle `a` in the map, at their first keyframes,
/// without alignment. Empty without keyframes of both.
/// @param halves the two are parts of one recording: taken in the middle of their overlap. They
/// start at different times, and earlier odometry errors of one are not an error of the other's
/// frame.
[[nodiscard]] std::optional<FrameError> frame_error(const Mission& mission, const Joined& joined,
                                                    std::size_t a, std::size_t b, bool halves);

/// Error of a loop along observable directions: directions whose sigma is larger than kKnown_m or
/// kKnown_rad are ignored.
[[nodiscard]] std::optional<FrameError> loop_error(const Mission& mission,
                                                   const fleet::LoopVerdict& loop);

}  // namespace rali::fleet_bench
