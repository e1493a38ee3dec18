#pragma once

#include <Eigen/Geometry>

#include "rali/geometry/so3.hpp"
#include "rali/odometry/robust/plane_map.hpp"

namespace rali::odometry {

/// A square of points for tests: side x side points, `spacing_m` apart, seen at normal incidence,
/// so that the fitted plane is exact.
struct Patch {
  geometry::Vec3 center = geometry::Vec3::Zero();
  geometry::Vec3 n = geometry::Vec3::UnitZ();
  int side = 10;
  double spacing_m = 0.05;
  double epoch = 0.0;
};

inline void insert_patch(PlaneMap& map, const Patch& patch) {
  const geometry::Mat3 R = geometry::rotation_between(geometry::Vec3::UnitZ(), patch.n);
  const geometry::Vec3f ray = patch.n.cast<float>();
  const double middle = 0.5 * (patch.side - 1);
  for (int i = 0; i < patch.side; ++i) {
    for (int j = 0; j < patch.side; ++j) {
      const geometry::Vec3 p((i - middle) * patch.spacing_m, (j - middle) * patch.spacing_m, 0.0);
      map.insert(patch.center + R * p, ray, patch.epoch);
    }
  }
}

/// A wall of map cells, `cells` in each direction from `first`, each filled by one patch; walls lie
/// in the middle of their cells.
inline void insert_wall(PlaneMap& map, const geometry::Vec3& first, const geometry::Vec3& n,
                        const geometry::Vec3& along, const geometry::Vec3& up, int cells_along,
                        int cells_up) {
  const double voxel_m = map.settings().voxel_m;
  for (int i = 0; i < cells_along; ++i) {
    for (int j = 0; j < cells_up; ++j) {
      Patch patch;
      patch.n = n;
      patch.spacing_m = 0.9 * voxel_m / patch.side;
      patch.center = first + voxel_m * (i * along + j * up);
      insert_patch(map, patch);
    }
  }
}

}  // namespace rali::odometry
