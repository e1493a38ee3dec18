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
  double cut_m = 1.0;             ///< farther points are counted but not averaged
  double complete_m = 0.1;        ///< a mesh sample counts as mapped if a point is this near
  double sample_spacing_m = 0.1;  ///< distance between the samples of the mesh
};

/// Unsigned distances of points to the nearest triangle, as CloudCompare's cloud-to-mesh distance.
struct CloudToMesh {
  Statistics all;                ///< of all points [m]
  Statistics within;             ///< of the points within cut_m [m]; population standard deviation
  double p95_m = 0.0;            ///< 95th percentile of the points within cut_m
  std::size_t beyond = 0;        ///< points beyond cut_m
  double fraction_beyond = 0.0;  ///< of all points
  std::size_t not_finite = 0;    ///< points without finite coordinates, ignored
  std::size_t samples = 0;       ///< of the mesh
  double completeness = 0.0;     ///< fraction of the mesh samples with a point within complete_m
};

/// Distance of each point to the mesh [m], in the order of the points.
[[nodiscard]] std::vector<double> distances_to_mesh(const PointList& points,
                                                    const TriangleTree& tree, Executor& executor);

/// @param points  in the frame of the cloud; thinned in that frame
/// @param T_mesh_cloud  the alignment
[[nodiscard]] CloudToMesh cloud_to_mesh(const PointList& points, const geometry::SE3& T_mesh_cloud,
                                        const TriangleMesh& mesh, const TriangleTree& tree,
                                        const CloudToMeshOptions& options, Executor& executor);

struct MeshIcpOptions {
  double overlap = 0.9;         ///< fraction of the points, the nearest ones, that is used
  double rmse_change_m = 1e-5;  ///< converged when the rmse changes less
  int iterations_max = 100;
  std::size_t points_max = 50000;  ///< more points are randomly reduced to this number
};

struct MeshIcp {
  geometry::SE3 T_mesh_cloud;
  double rmse_start_m = 0.0, rmse_m = 0.0;  ///< of the used points
  int iterations = 0;
  bool converged = false;
  int open_directions = 0;  ///< degenerate ones among the six; they keep their initial values
};

/// Aligns a cloud to a mesh by Gauss-Newton on the distances to the nearest triangles, starting at
/// T_mesh_cloud. Finds only the local minimum. Errors (kNoAnswer): fewer than 10 points.
[[nodiscard]] Result<MeshIcp> align_to_mesh(const PointList& points,
                                            const geometry::SE3& T_mesh_cloud,
                                            const TriangleTree& tree, const MeshIcpOptions& options,
                                            Executor& executor);

}  // namespace rali::eval
