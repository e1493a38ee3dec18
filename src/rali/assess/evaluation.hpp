#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/assess/input.hpp"
#include "rali/assess/score.hpp"
#include "rali/base/executor.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/cloud_to_mesh.hpp"
#include "rali/eval/map_shape.hpp"

namespace rali::assess {

struct EvaluationOptions {
  eval::Alignment align = eval::Alignment::kSe3;
  bool each = false;  ///< one transform per vehicle instead of one for the fleet
  std::vector<double> distances_m = {1.0, 10.0, 50.0};  ///< of the relative pose error
  bool all_pairs = true;
  eval::AssociationOptions associate{eval::AssociationMode::kInterpolate, 0.01, 0.2};
  bool mesh_icp = false;
};

/// One frame of the estimate and its alignment to the frame of the ground truth.
struct FrameScore {
  std::vector<std::string> vehicles;
  geometry::SE3 T_truth_est;
  eval::Alignment used = eval::Alignment::kSe3;  ///< differs from the request on straight
                                                 ///< trajectories
};

struct VehicleScore {
  std::string name;
  TrackScore trajectory;               ///< final poses, one alignment for the frame
  std::optional<TrackScore> live;      ///< poses in map as estimated live, one alignment
  std::optional<TrackScore> odometry;  ///< as processed, aligned by itself
  std::vector<PoseRow> rows;           ///< of the trajectory
};

/// Relative pose error between two vehicles at equal times, without any alignment.
struct PairScore {
  std::string a, b;
  eval::Statistics translation_m, rotation_rad;
};

struct CloudScore {
  std::string file;
  std::size_t points = 0;
  eval::MapShape shape;
  std::optional<eval::CloudToMesh> to_mesh;  ///< after all alignment
  std::optional<eval::CloudToMesh> before_icp;
  std::optional<eval::MeshIcp> icp;
};

struct Evaluation {
  std::string input, truth, mesh;  ///< as given; empty if absent
  EvaluationOptions options;
  std::vector<FrameScore> frames;
  std::vector<VehicleScore> vehicles;
  TrackScore fleet;  ///< all vehicles together
  std::optional<TrackScore> fleet_live, fleet_odometry;
  std::vector<PairScore> between;
  std::optional<CloudScore> cloud;
  std::vector<std::string> warnings;

  /// Alignment and association as text, part of every result.
  [[nodiscard]] std::string how() const;
};

/// Evaluates the vehicles with ground truth. Errors: kInput (no common time, poses out of order),
/// kNoAnswer (no alignment).
[[nodiscard]] Result<Evaluation> evaluate_tracks(const RunInput& run,
                                                 const EvaluationOptions& options);

/// Adds the evaluation of a cloud to `result`.
/// @param mesh  nullptr: sharpness of the map, without ground truth
/// @param T_mesh_cloud  usually FrameScore::T_truth_est of the first frame
[[nodiscard]] Status evaluate_cloud(const std::string& file, const eval::PointList& points,
                                    const eval::TriangleMesh* mesh,
                                    const geometry::SE3& T_mesh_cloud, Executor& executor,
                                    Evaluation& result);

/// x, y, z of a cloud file. Errors: kInput.
[[nodiscard]] Result<eval::PointList> read_points(const std::string& path);

}  // namespace rali::assess
