#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/clearance.hpp"
#include "rali/sim/navigation.hpp"

namespace rali::scenario {

using Way = std::vector<geometry::Vec3>;

/// True if a point of a scene file was given; coordinates that were not are NaN.
[[nodiscard]] bool is_given(const geometry::Vec3& p);

/// Finds ways through a place and puts points on its ground. `name` and `where` are for messages.
/// The navigation grid is made when first needed.
class Surveyor {
 public:
  explicit Surveyor(const sim::TriangleMesh& mesh) : mesh_(&mesh), clearance_(mesh) {}

  /// The given point on the ground: the surface nearest to its height; the lowest if it has none.
  /// Errors (kUsage): no ground; in a wall or too near to one.
  [[nodiscard]] Result<geometry::Vec3> on_ground(const geometry::Vec3& p, const std::string& name,
                                                 const std::string& where) const;

  /// The way from `from` on with its points on the ground. Errors (kUsage): no ground.
  [[nodiscard]] Result<Way> along_ground(const Way& way, const geometry::Vec3& from,
                                         const std::string& name, const std::string& where) const;

  /// A way that keeps off walls. Errors: NavigationGrid::plan.
  [[nodiscard]] Result<Way> planned(const geometry::Vec3& from, const geometry::Vec3& to,
                                    const std::string& where);

  /// The longest of all shortest ways from `from`; if that is not given, about the longest within
  /// the part of the world to which the first free place `inside` belongs.
  /// Errors (kUsage): no vehicle fits.
  [[nodiscard]] Result<Way> longest(const geometry::Vec3& from,
                                    const std::function<bool(const geometry::Vec3&)>& inside,
                                    const std::string& where);

  /// Nothing in the way of a vehicle that drives it with rounded corners. Errors (kUsage).
  [[nodiscard]] Status check_way(const Way& way, double rounding_m, const std::string& name,
                                 const std::string& where) const;

  /// Of a vehicle.
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
