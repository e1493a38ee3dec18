#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::assess {

/// Poses of one vehicle with what its files say about them.
struct Track {
  eval::PoseList poses;  ///< in the file's frame
  /// Of geometry::boxplus, one per pose, NaN where the file has none; empty without a file.
  std::vector<geometry::Mat6> covariances;
};

/// All that is known of one vehicle.
struct VehicleInput {
  std::string name;
  Track trajectory;  ///< final: `trajectory/<v>.tum`, or the one file that was given
  Track live;        ///< in map as known at the time: `live/<v>.tum`; empty if there is none
  Track odometry;    ///< as processed: `odometry/<v>.tum`; empty if there is none
  /// Direction in map per pose of the trajectory, zero where not blind; empty without a file.
  std::vector<geometry::Vec3> blind_map;
  eval::PoseList truth;  ///< T_world_body; empty if there is none
  std::string file, truth_file;
  /// Whether gravity levelled the trajectory's frame, where its file says so.
  std::optional<bool> levelled;
  double time_offset_s = 0.0;  ///< that rali map added to the LiDAR's stamps (metrics.json)
};

/// What is to be judged.
struct RunInput {
  std::string name;  ///< as the user gave it
  bool out_folder = false;
  std::vector<VehicleInput> vehicles;  ///< in natural order of their names
  /// Indices of vehicles that share one frame, largest group first. The first vehicle of a group is
  /// its reference: its first pose fixes the frame.
  std::vector<std::vector<std::size_t>> groups;
  std::string cloud;                  ///< path of the map; empty if there is none
  std::vector<std::string> warnings;  ///< sentences for the user
};

/// Reads a folder written by `rali map` or `rali run --poses`, a trajectory (TUM), or a cloud (.pcd
/// .ply .bin). Errors: kInput with file and line; a folder without any trajectory or map.
[[nodiscard]] Result<RunInput> read_run(const std::string& path);

/// Adds the truth: a folder with `<vehicle>.tum`, or one TUM file for one vehicle. Vehicles
/// without a truth are named in the warnings.
/// @param T_body_truth  pose in the body of what the truth follows (a prism, an antenna)
/// Errors: kInput; no vehicle has a truth.
[[nodiscard]] Status add_truth(const std::string& path, const geometry::SE3& T_body_truth,
                               RunInput& run);

/// `truth/mesh.ply` (or .obj, .stl) of a truth folder; empty if there is none.
[[nodiscard]] std::string mesh_beside_truth(const std::string& truth);

}  // namespace rali::assess
