#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/joint_ranges.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/messages/separator_prior.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Levelled odom: the frame that FrameSolver uses for a vehicle.
[[nodiscard]] geometry::SE3 T_level_odom(const VehiclePath& path);

/// For a single vehicle: the map's origin and heading are those of its first body, z is up.
[[nodiscard]] geometry::SE3 T_map_odom_alone(const VehiclePath& path);

/// Its key in FrameSolver.
[[nodiscard]] StreamKey stream_of(const VehiclePath& path);

/// The path of that key; null if there is none.
[[nodiscard]] const VehiclePath* path_of(std::span<const VehiclePath> paths, StreamKey stream);

/// Index of the first node of each path that is not fixed by earlier rounds: 0 without earlier
/// rounds, and for a path that is not in the separator prior. @param before may be null
[[nodiscard]] std::vector<std::size_t> begins_of(std::span<const VehiclePath> paths,
                                                 const SeparatorPrior* before);

/// Passes all ranges between paths to a solver.
void add_ranges(std::span<const VehiclePath> paths, const JointRanges& ranges, FrameSolver& solver);

/// A start pose measured by hand, with its own sigmas.
void add_start(const VehiclePath& relative_to, const VehiclePath& path,
               const geometry::SE3& T_relative_path, double sigma_m, double sigma_rad,
               InitSettings settings, FrameSolver& solver);

/// Joined paths: of each path the index of its group and the pose of its odom in the group's map,
/// whose origin and heading are those of the group's first body.
struct PathFrames {
  std::vector<std::vector<std::size_t>> groups;      ///< largest first, the reference first
  std::vector<std::size_t> group;                    ///< per path
  std::vector<geometry::SE3> T_map_odom;             ///< per path
  std::vector<std::optional<DecidedBy>> decided_by;  ///< per path; nothing: the group's first
};

[[nodiscard]] PathFrames frames_of(std::span<const VehiclePath> paths, const FleetFrames& frames);

}  // namespace rali::fleet
