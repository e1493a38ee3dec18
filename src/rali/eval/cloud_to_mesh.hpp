#pragma once

#include <vector>

#include "rali/base/executor.hpp"
#include "rali/eval/point_grid.hpp"
#include "rali/eval/statistics.hpp"
#include "rali/eval/triangle_tree.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::eval {

struct CloudToMeshOptions {
  double thin_m = 0.05;           ///< one point per cube of this size; 0 keeps all
  double cut_m = 1.0;             ///< points farther from the mesh are counted, not averaged
  double complete_m = 0.1;        ///< a piece of mesh counts as mapped with a point this near
  double sample_spacing_m = 0.1;  ///< between the samples of the mesh
};

/// Unsigned distances of points to the nearest triangle, as CloudCompare's cloud-to-mesh distance.
struct CloudToMesh {
  Statistics all;              ///< of all points [m]
  Statistics within;           ///< of the points within cut_m [m]; std is of the population
  double p95_m = 0.0;          ///< 95 % of the points within cut_m are nearer
  std::size_t beyond = 0;      ///< points beyond cut_m
  double share_beyond = 0.0;   ///< of all points
  std::size_t not_finite = 0;  ///< points without finite coordinates, left out
  std::size_t samples = 0;     ///< of the mesh
  double completeness = 0.0;   ///< share of the mesh samples with a point within complete_m
};

/// Distance of each point to the mesh [m], in the order of the points.
[[nodiscard]] std::vector<double> distances_to_mesh(const PointList& points,
                                                    const TriangleTree& tree, Executor& executor);

/// @param points  in the frame of the cloud; thinned there
/// @param T_mesh_cloud  the alignment
[[nodiscard]] CloudToMesh cloud_to_mesh(const PointList& points, const geometry::SE3& T_mesh_cloud,
                                        const TriangleMesh& mesh, const TriangleTree& tree,
                                        const CloudToMeshOptions& options, Executor& executor);

struct MeshIcpOptions {
  double overlap = 0.9;         ///< share of the points, the nearest ones, that count
  double rmse_change_m = 1e-5;  ///< ends when the rmse changes less
  int iterations_max = 100;
  std::size_t points_max = 50000;  ///< a draw of more points
};

struct MeshIcp {
  geometry::SE3 T_mesh_cloud;
  double rmse_start_m = 0.0, rmse_m = 0.0;  ///< of the points that count
  int iterations = 0;
  bool converged = false;
  int open_directions = 0;  ///< of the six; the mesh does not tell them and they stay as given
};

/// Lays a cloud onto a mesh by Gauss-Newton on the distances to the nearest triangles, starting at
/// T_mesh_cloud. Finds the nearest minimum, no better. Errors (kNoAnswer): fewer than 10 points.
[[nodiscard]] Result<MeshIcp> align_to_mesh(const PointList& points,
                                            const geometry::SE3& T_mesh_cloud,
                                            const TriangleTree& tree, const MeshIcpOptions& options,
                                            Executor& executor);

}  // namespace rali::eval
