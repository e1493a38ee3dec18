#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/geometry/types.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

/// Limits of what a vehicle can traverse.
struct NavigationOptions {
  double cell_m = 0.1;    ///< grows on worlds with too many cells
  double radius_m = 0.3;  ///< of the vehicle
  double height_m = 0.9;  ///< free height required
  double step_m = 0.12;   ///< largest step between neighbouring cells
  double prefer_m = 0.7;  ///< paths keep this far from walls where they can
};

/// Traversable cells of a world with several storeys: cells of the plan view, each with the heights
/// of drivable ground. Built from the mesh alone, so it works for any world. Source of the cell
/// structure: Mononen, Recast ("compact heightfield").
class NavigationGrid {
 public:
  /// Errors (kUsage): the mesh has no triangle, or is larger than 30 million cells.
  [[nodiscard]] static Result<NavigationGrid> build(const TriangleMesh& mesh,
                                                    const NavigationOptions& options = {});

  /// True if a vehicle fits here; p on the ground, within 0.5 m in height.
  [[nodiscard]] bool free_at(const geometry::Vec3& p) const;

  /// Index, from 0, of the connected component of the grid at p: two positions with a path between
  /// them have the same index. -1: a vehicle does not fit here.
  [[nodiscard]] std::int32_t part_at(const geometry::Vec3& p) const;

  /// Height of drivable ground at (x, y), the one nearest to z_m.
  [[nodiscard]] std::optional<double> ground_at(double x_m, double y_m, double z_m) const;

  /// Distance along the ground to the nearest untraversable cell (octile, at most 8 % too long).
  [[nodiscard]] double clearance_m(const geometry::Vec3& p) const;

  /// Corners of a short path on the ground that keeps away from walls (A*; deterministic).
  /// Errors: kUsage if an end is not free (where = "from" or "to"); kNoAnswer if there is no path.
  [[nodiscard]] Result<std::vector<geometry::Vec3>> plan(const geometry::Vec3& from,
                                                         const geometry::Vec3& to) const;

  /// Of all positions reachable from `from`, the one with the longest path.
  /// Errors: kUsage if `from` is not free.
  [[nodiscard]] Result<geometry::Vec3> farthest_from(const geometry::Vec3& from) const;

  [[nodiscard]] double cell_m() const { return options_.cell_m; }

  /// Centres of all cells that a vehicle can occupy: for pictures.
  [[nodiscard]] std::vector<geometry::Vec3> free_cells() const;

 private:
  /// A height of drivable ground in one cell.
  struct Node {
    std::int32_t x = 0, y = 0;
    float z_m = 0.0F;
    float clearance_m = 0.0F;
    std::int32_t part = -1;
    std::array<std::int32_t, 8> next{};  ///< by kSteps; -1: none
  };

  explicit NavigationGrid(const NavigationOptions& options) : options_(options) {}

  void make_nodes(const TriangleMesh& mesh);
  void link_nodes();
  void measure_clearance();
  void find_parts();
  [[nodiscard]] std::int32_t node_at(std::int64_t x, std::int64_t y, double z_m,
                                     double reach_m) const;
  [[nodiscard]] std::int32_t node_of(const geometry::Vec3& p) const;
  [[nodiscard]] geometry::Vec3 centre(std::int32_t node) const;
  [[nodiscard]] bool passable(std::int32_t node) const;
  /// Smallest clearance on the straight line between two nodes; negative: not traversable.
  [[nodiscard]] double line_clearance(std::int32_t from, std::int32_t to) const;
  [[nodiscard]] std::vector<std::int32_t> shortened(const std::vector<std::int32_t>& path) const;
  /// Dijkstra or A* (to >= 0) from one node: predecessor and cost of each node.
  void search(std::int32_t from, std::int32_t to, std::vector<std::int32_t>& before,
              std::vector<float>& cost) const;

  NavigationOptions options_;
  geometry::Vec2 low_ = geometry::Vec2::Zero();
  std::vector<Node> nodes_;  ///< sorted by y, x, z
};

}  // namespace rali::sim
