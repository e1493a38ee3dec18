#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/clearance.hpp"
#include "rali/sim/navigation.hpp"

namespace rali::sim {

/// A way that a rover can follow without touching anything.
struct PlannedWay {
  std::vector<geometry::Vec3> corners;  ///< on the ground
  double rounding_m = 0.0;
};

/// Finds ways for rovers in a world: with room to spare where there is room, and through narrow
/// doors where there is none.
class WayPlanner {
 public:
  /// Keeps a reference to the mesh. Errors: see NavigationGrid::build().
  [[nodiscard]] static Result<WayPlanner> make(const TriangleMesh& mesh);

  /// From `from` through `places` in order. An end that is too near to an obstacle is moved to the
  /// nearest free place within 1.5 m from which a path leads on.
  /// @param others  where other vehicles stand, to go around them
  /// Errors (kNoAnswer): no free place near an end, or no way between two.
  [[nodiscard]] Result<PlannedWay> plan(const geometry::Vec3& from,
                                        std::span<const geometry::Vec3> places,
                                        std::span<const geometry::Vec3> others) const;

 private:
  WayPlanner(const TriangleMesh& mesh, NavigationGrid wide, NavigationGrid narrow);

  const TriangleMesh* mesh_;
  NavigationGrid wide_, narrow_;
  Clearance clearance_;
};

}  // namespace rali::sim
