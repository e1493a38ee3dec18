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

/// What `rali evaluate` has as options.
struct EvaluateOptions {
  std::string truth;  ///< folder with <vehicle>.tum, or one file; empty: the map alone is judged
  std::string mesh;   ///< surfaces; empty: mesh.ply beside the truth, if there
  Pose3 T_body_truth = Pose3::Identity();  ///< of what the truth follows (a prism, an antenna)
  Alignment alignment = Alignment::kSe3;
  bool each = false;  ///< one alignment per vehicle instead of one for the fleet
  std::vector<double> distances_m = {1.0, 10.0, 50.0};  ///< of the relative pose error
  int threads = 0;  ///< 0: one per core; results do not depend on it
  std::string out;  ///< folder of evaluation.json; empty: that of the run; no run: nowhere
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
  std::string name;                     ///< of the vehicle; "fleet": of all together
  std::size_t poses = 0;                ///< compared
  double distance_m = 0.0;              ///< along the ground truth
  ErrorStatistics ape_m, rotation_rad;  ///< absolute pose error
  std::vector<RelativeError> rpe;
  double nees = std::numeric_limits<double>::quiet_NaN();  ///< mean, expected 6; NaN: not known
};

/// Distances of the map's points from the mesh, those within 1 m.
struct CloudErrors {
  std::size_t points = 0;
  ErrorStatistics to_mesh_m;     ///< count 0: no mesh
  double fraction_beyond = 0.0;  ///< of the points, beyond 1 m
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
