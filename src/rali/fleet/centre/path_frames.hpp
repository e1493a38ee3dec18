#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/fleet/centre/joint_ranges.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/messages/boundary.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// Odom turned upright: the frame that FrameSolver knows of a vehicle.
[[nodiscard]] geometry::SE3 T_level_odom(const VehiclePath& path);

/// Of a vehicle alone: the map's origin and heading are those of its first body, z is up.
[[nodiscard]] geometry::SE3 T_map_odom_alone(const VehiclePath& path);

/// The name that FrameSolver knows it by.
[[nodiscard]] StreamKey stream_of(const VehiclePath& path);

/// The path of that name; null if there is none.
[[nodiscard]] const VehiclePath* path_of(std::span<const VehiclePath> paths, StreamKey stream);

/// Of each path the index of its first node that earlier rounds leave open: 0 where there was none,
/// and of a path that the boundary does not know. @param before may be null
[[nodiscard]] std::vector<std::size_t> begins_of(std::span<const VehiclePath> paths,
                                                 const RoundBoundary* before);

/// Hands a solver all ranges between paths.
void add_ranges(std::span<const VehiclePath> paths, const JointRanges& ranges, FrameSolver& solver);

/// A start pose measured by hand, with its own sigmas.
void add_start(const VehiclePath& relative_to, const VehiclePath& path,
               const geometry::SE3& T_relative_path, double sigma_m, double sigma_rad,
               InitSettings settings, FrameSolver& solver);

/// How the paths hang together: of each path the index of its group and the pose of its odom in the
/// group's map, whose origin and heading are those of the group's first body.
struct PathFrames {
  std::vector<std::vector<std::size_t>> groups;  ///< largest first, the reference first
  std::vector<std::size_t> group;                ///< per path
  std::vector<geometry::SE3> T_map_odom;         ///< per path
  std::vector<std::string> decided_by;           ///< per path; empty: the group's first
};

[[nodiscard]] PathFrames frames_of(std::span<const VehiclePath> paths, const FleetFrames& frames);

}  // namespace rali::fleet
