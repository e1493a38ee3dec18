#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/sim/mesh.hpp"

namespace rali::sim {

/// A feature of a straight wall at a distance along it. Depth > 0: recessed behind the wall; < 0:
/// it protrudes from the wall.
struct WallFeature {
  double at_m = 0.0;  ///< centre along the wall
  double width_m = 0.9;
  double bottom_m = 0.0;
  double top_m = 2.1;
  double depth_m = 0.07;
  double refl = 0.5;
  bool open = false;  ///< a hole instead of a back face
};

/// Adds building parts to a mesh. The front of a wall is the left side of the direction a to b;
/// "behind" is the right side.
class Builder {
 public:
  Builder(TriangleMesh& mesh, Rng& rng) : mesh_(mesh), rng_(rng) {}

  /// Wall from a to b with its foot at z = a.z(); features sorted by at_m and not overlapping.
  void wall(const geometry::Vec3& a, const geometry::Vec3& b, double height_m,
            const std::vector<WallFeature>& features, double refl = 0.6);

  /// Wall with typical features of a building: doors, radiators, cabinets, pilasters about every
  /// `spacing_m`. With `room_depth_m` > 0 some doors are open to furnished rooms of that depth.
  void lived_in_wall(const geometry::Vec3& a, const geometry::Vec3& b, double height_m,
                     double spacing_m, double room_depth_m);

  /// Floor or ceiling: horizontal rectangle.
  void slab(double x0, double y0, double x1, double y1, double z, double refl = 0.4);

  /// Parallelogram at `corner` along u, v in cells of about cell_m, displaced by noise of
  /// amplitude_m.
  void rough_quad(const geometry::Vec3& corner, const geometry::Vec3& u, const geometry::Vec3& v,
                  double cell_m, double amplitude_m, double grain_m, std::uint64_t seed,
                  double refl);

  /// Some tables, shelves and boxes inside the parallelogram corner, u, v.
  void furnish(const geometry::Vec3& corner, const geometry::Vec3& u, const geometry::Vec3& v,
               int pieces);

  [[nodiscard]] Rng& rng() { return rng_; }

  [[nodiscard]] TriangleMesh& mesh() { return mesh_; }

 private:
  void room_behind(const geometry::Vec3& door, const geometry::Vec3& along,
                   const geometry::Vec3& behind, double width_m, double depth_m, double height_m,
                   double door_width_m);

  TriangleMesh& mesh_;
  Rng& rng_;
};

}  // namespace rali::sim
