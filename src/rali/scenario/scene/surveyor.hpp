#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/clearance.hpp"
#include "rali/sim/navigation.hpp"

namespace rali::scenario {

using Path = std::vector<geometry::Vec3>;

/// True if a point of a scene file was given; missing coordinates are NaN.
[[nodiscard]] bool is_given(const geometry::Vec3& p);

/// Plans paths through a world and projects points to its ground. `name` and `where` are for
/// messages. The navigation grid is built on first use.
class Surveyor {
 public:
  explicit Surveyor(const sim::TriangleMesh& mesh) : mesh_(&mesh), clearance_(mesh) {}

  /// The given point on the ground: the surface nearest to its height; the lowest if it has none.
  /// Errors (kUsage): no ground; in a wall or too close to one.
  [[nodiscard]] Result<geometry::Vec3> on_ground(const geometry::Vec3& p, const std::string& name,
                                                 const std::string& where) const;

  /// The path, continued from `from`, with its points on the ground. Errors (kUsage): no ground.
  [[nodiscard]] Result<Path> along_ground(const Path& path, const geometry::Vec3& from,
                                          const std::string& name, const std::string& where) const;

  /// A path that keeps away from walls. Errors: NavigationGrid::plan.
  [[nodiscard]] Result<Path> planned(const geometry::Vec3& from, const geometry::Vec3& to,
                                     const std::string& where);

  /// The longest of all shortest paths from `from`. If that is not given, approximately the longest
  /// one in the part of the world that contains the first free position that is `inside`.
  /// Errors (kUsage): no vehicle fits.
  [[nodiscard]] Result<Path> longest(const geometry::Vec3& from,
                                     const std::function<bool(const geometry::Vec3&)>& inside,
                                     const std::string& where);

  /// Checks that a vehicle touches nothing on the path with rounded corners. Errors (kUsage).
  [[nodiscard]] Status check_path(const Path& path, double rounding_m, const std::string& name,
                                  const std::string& where) const;

  /// Radius of a vehicle.
  [[nodiscard]] double radius_m() const { return shape_.radius_m; }

 private:
  Result<sim::NavigationGrid*> grid_of(double radius_m);

  const sim::TriangleMesh* mesh_;
  sim::Clearance clearance_;
  sim::VehicleShape shape_;
  std::unique_ptr<sim::NavigationGrid> grid_;
  double grid_radius_m_ = 0.0;
};

}  // namespace rali::scenario
