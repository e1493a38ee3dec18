#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/geometry/types.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

/// Volume occupied by a vehicle: an upright cylinder above its position on the ground.
struct VehicleShape {
  double radius_m = 0.3;
  double low_m = 0.12;  ///< lower obstacles are driven over: sills, uneven ground
  double high_m = 0.9;
};

/// Distance between vehicles and the surfaces of a mesh; exact in any kind of world. Keeps a
/// reference to the mesh.
class Clearance {
 public:
  explicit Clearance(const TriangleMesh& mesh);

  /// Horizontal distance from `ground` to the nearest surface within the height range of the
  /// vehicle, at most limit_m.
  [[nodiscard]] double distance_m(const geometry::Vec3& ground, const VehicleShape& shape,
                                  double limit_m) const;

  /// True if a vehicle at this position touches nothing.
  [[nodiscard]] bool free_at(const geometry::Vec3& ground, const VehicleShape& shape) const {
    return distance_m(ground, shape, shape.radius_m) >= shape.radius_m;
  }

  /// The first point, in steps of 0.1 m, where a vehicle on this path touches something.
  [[nodiscard]] std::optional<geometry::Vec3> first_contact(const std::vector<geometry::Vec3>& path,
                                                            const VehicleShape& shape) const;

  /// Height of the highest surface below (x, y, from_z_m), at most depth_m below it.
  [[nodiscard]] std::optional<double> ground_below(double x_m, double y_m, double from_z_m,
                                                   double depth_m) const;

  /// Heights of all surfaces over (x, y), lowest first.
  [[nodiscard]] std::vector<double> surfaces_at(double x_m, double y_m) const;

 private:
  [[nodiscard]] std::int64_t bin_of(double value, int axis) const;
  /// Calls use(triangle) for all triangles near the square of half-width half_m around (x, y).
  template <class Use>
  void visit_near(double x_m, double y_m, double half_m, const Use& use) const;

  const TriangleMesh* mesh_;
  double bin_m_ = 1.0;
  geometry::Vec2 low_ = geometry::Vec2::Zero();
  std::int64_t bins_x_ = 0, bins_y_ = 0;
  std::vector<std::uint32_t> begin_;      ///< by bin, into triangles_
  std::vector<std::uint32_t> triangles_;  ///< bin after bin
};

}  // namespace rali::sim
