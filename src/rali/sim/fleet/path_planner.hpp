#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/clearance.hpp"
#include "rali/sim/navigation.hpp"

namespace rali::sim {

/// A path that a rover can follow without touching anything.
struct PlannedPath {
  std::vector<geometry::Vec3> corners;  ///< on the ground
  double rounding_m = 0.0;
};

/// Plans paths for rovers in a world: with extra clearance where possible, else through narrow
/// doors without it.
class PathPlanner {
 public:
  /// Keeps a reference to the mesh. Errors: see NavigationGrid::build().
  [[nodiscard]] static Result<PathPlanner> make(const TriangleMesh& mesh);

  /// From `from` through `places` in order. An end too close to an obstacle is moved to the nearest
  /// free position within 1.5 m that has a path to the rest.
  /// @param others  positions of other vehicles, which the path avoids
  /// Errors (kNoAnswer): no free position near an end, or no path between two.
  [[nodiscard]] Result<PlannedPath> plan(const geometry::Vec3& from,
                                         std::span<const geometry::Vec3> places,
                                         std::span<const geometry::Vec3> others) const;

 private:
  PathPlanner(const TriangleMesh& mesh, NavigationGrid wide, NavigationGrid narrow);

  const TriangleMesh* mesh_;
  NavigationGrid wide_, narrow_;
  Clearance clearance_;
};

}  // namespace rali::sim
