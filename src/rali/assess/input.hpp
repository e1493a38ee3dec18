#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::assess {

/// Poses of one vehicle with data from its files.
struct Track {
  eval::PoseList poses;  ///< in the file's frame
  /// Of geometry::boxplus, one per pose, NaN where the file has none; empty without a file.
  std::vector<geometry::Mat6> covariances;
};

/// All inputs of one vehicle.
struct VehicleInput {
  std::string name;
  Track trajectory;  ///< final: `trajectory/<v>.tum`, or the one file that was given
  Track live;        ///< poses in map as estimated live: `live/<v>.tum`; empty if absent
  Track odometry;    ///< as processed: `odometry/<v>.tum`; empty if absent
  /// Direction in map per pose of the trajectory, zero where not degenerate; empty without a file.
  std::vector<geometry::Vec3> degenerate_map;
  eval::PoseList truth;  ///< T_world_body; empty if absent
  std::string file, truth_file;
  /// Whether gravity levelled the trajectory's frame, if its file contains that.
  std::optional<bool> levelled;
  double time_offset_s = 0.0;  ///< that rali map added to the LiDAR's stamps (metrics.json)
};

/// The input of an evaluation.
struct RunInput {
  std::string name;  ///< as the user gave it
  bool out_folder = false;
  std::vector<VehicleInput> vehicles;  ///< in natural order of their names
  /// Indices of vehicles that share one frame, largest group first. The first vehicle of a group is
  /// its reference: its first pose fixes the frame.
  std::vector<std::vector<std::size_t>> groups;
  std::string cloud;                  ///< path of the map; empty if absent
  std::vector<std::string> warnings;  ///< sentences for the user
};

/// Reads a folder written by `rali map` or `rali run --poses`, a trajectory (TUM), or a cloud (.pcd
/// .ply .bin). Errors: kInput with file and line; a folder without any trajectory or map.
[[nodiscard]] Result<RunInput> read_run(const std::string& path);

/// Adds the ground truth: a folder with `<vehicle>.tum`, or one TUM file for one vehicle. Vehicles
/// without one are named in the warnings.
/// @param T_body_truth  pose in the body of the tracked point (a prism, an antenna)
/// Errors: kInput; no vehicle has ground truth.
[[nodiscard]] Status add_truth(const std::string& path, const geometry::SE3& T_body_truth,
                               RunInput& run);

/// `truth/mesh.ply` (or .obj, .stl) of a ground-truth folder; empty if absent.
[[nodiscard]] std::string mesh_beside_truth(const std::string& truth);

}  // namespace rali::assess
