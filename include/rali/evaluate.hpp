#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "rali/error.hpp"
#include "rali/types.hpp"

namespace rali {

/// How estimate and ground truth are aligned.
enum class Alignment { kSe3, kYaw, kOrigin, kNone };

/// The options of `rali evaluate`.
struct EvaluateOptions {
  std::string truth;  ///< folder with <vehicle>.tum, or one file; empty: only the map is evaluated
  std::string mesh;   ///< surfaces; empty: mesh.ply in the ground-truth folder, if present
  Pose3 T_body_truth = Pose3::Identity();  ///< of the tracked point (a prism, an antenna)
  Alignment alignment = Alignment::kSe3;
  bool each = false;  ///< one alignment per vehicle instead of one for the fleet
  std::vector<double> distances_m = {1.0, 10.0, 50.0};  ///< of the relative pose error
  int threads = 0;  ///< 0: one per core; results do not depend on it
  std::string out;  ///< folder of evaluation.json; empty: the run's folder; without a run: not
                    ///< written
};

/// All zero where nothing was measured.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0.0, mean = 0.0, median = 0.0, std = 0.0, min = 0.0, max = 0.0;
};

/// Relative pose error over a distance travelled.
struct RelativeError {
  double distance_m = 0.0;
  ErrorStatistics translation_m, rotation_rad;
};

/// Errors of a trajectory.
struct TrackErrors {
  std::string name;                     ///< of the vehicle; "fleet": all vehicles together
  std::size_t poses = 0;                ///< number of compared poses
  double distance_m = 0.0;              ///< along the ground truth
  ErrorStatistics ape_m, rotation_rad;  ///< absolute pose error
  std::vector<RelativeError> rpe;
  double nees = std::numeric_limits<double>::quiet_NaN();  ///< mean, expected 6; NaN: unknown
};

/// Distances from the map's points to the mesh, for points within 1 m of it.
struct CloudErrors {
  std::size_t points = 0;
  ErrorStatistics to_mesh_m;     ///< count 0: no mesh
  double fraction_beyond = 0.0;  ///< fraction of the points farther than 1 m
};

struct Evaluation {
  TrackErrors fleet;
  std::vector<TrackErrors> vehicles;
  CloudErrors cloud;
  std::vector<std::string> warnings;
  std::string json;   ///< text of evaluation.json
  std::string table;  ///< as `rali evaluate` prints it
};

/// Compares results with a ground truth.
/// @param input folder of a run, a trajectory (TUM), or a cloud
/// Throws SettingsError (a trajectory without truth), InputError, NoAnswerError (no common times),
/// MachineError.
[[nodiscard]] Evaluation evaluate(const std::string& input, const EvaluateOptions& options);

}  // namespace rali
