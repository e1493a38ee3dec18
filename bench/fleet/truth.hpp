#pragma once

#include <optional>
#include <vector>

#include "join.hpp"

namespace rali::fleet_bench {

/// True pose of a vehicle at the last point of the sweep that ended at t.
[[nodiscard]] std::optional<geometry::SE3> truth_at(const Mission& mission, VehicleId vehicle,
                                                    Time t);

/// Poses in the map, beside the truth, of one vehicle; diverged ones are left out.
[[nodiscard]] eval::PairList pairs_of(const Driven& driven, const Path& path);

/// What is off between two frames: T_ref^-1 T_est as a distance and an angle.
struct FrameError {
  double distance_m = 0.0;
  double angle_rad = 0.0;
};

/// How far the place of vehicle `b` in the map of vehicle `a` is off, at their first keyframes: no
/// alignment at all. Nothing without keyframes of both.
/// @param halves of one recording: in the middle of what both have; they begin at different times,
/// and what the odometry of one does before is no error of the other's frame
[[nodiscard]] std::optional<FrameError> frame_error(const Mission& mission, const Joined& joined,
                                                    std::size_t a, std::size_t b, bool halves);

/// What is wrong with a loop, as far as it claims to know: errors along directions whose sigma is
/// larger than kKnown_m or kKnown_rad are no errors.
[[nodiscard]] std::optional<FrameError> loop_error(const Mission& mission,
                                                   const fleet::LoopVerdict& loop);

}  // namespace rali::fleet_bench
