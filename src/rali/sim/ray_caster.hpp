#pragma once

#include <memory>
#include <span>
#include <vector>

#include "rali/sim/mesh.hpp"

namespace rali::sim {

/// Hit point of a ray.
struct Hit {
  float range_m = 0.0F;        ///< 0: no surface within range
  float cos_incidence = 0.0F;  ///< of the angle to the surface normal, 0..1
  float reflectivity = 0.0F;
};

/// A ray in the world frame; the direction has length 1.
struct Ray {
  geometry::Vec3 origin;
  geometry::Vec3 direction;
};

/// Casts rays against a fixed mesh (Embree). Casting is const: several threads may do it at once.
class RayCaster {
 public:
  explicit RayCaster(const TriangleMesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// First surface from `origin` along the unit vector `direction` within max_range_m.
  [[nodiscard]] Hit cast(const geometry::Vec3& origin, const geometry::Vec3& direction,
                         double max_range_m) const;

  /// The same for many rays, faster: neighbours in the list should have similar directions.
  /// hits has the size of rays.
  void cast_all(std::span<const Ray> rays, double max_range_m, std::span<Hit> hits) const;

  /// Distance of a point to the nearest surface, at most `limit_m`. Slow: tests every triangle; for
  /// checks of few points.
  [[nodiscard]] double distance_to_surface(const geometry::Vec3& point, double limit_m) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali::sim
