#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/map/map_cloud.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

/// Second moments of points in cubes of 0.4 m: which of them hold a plane, and how thick it is.
class PlaneGrid {
 public:
  static constexpr double kSide_m = 0.4;

  void add(const geometry::Vec3& p_m);

  struct Voxel {
    std::uint64_t points = 0;
    geometry::Vec3 sum_m = geometry::Vec3::Zero();      ///< of offsets from the corner
    geometry::Mat3 square_m2 = geometry::Mat3::Zero();  ///< of the same
  };

  [[nodiscard]] const std::vector<Voxel>& voxels() const { return voxels_; }

  /// Root of the smallest eigenvalue of the scatter [m]; negative if the cube holds no plane.
  [[nodiscard]] static double plane_thickness_m(const Voxel& voxel);
  /// Of each voxel that holds a plane its normal.
  [[nodiscard]] std::vector<std::optional<geometry::Vec3>> normals() const;

  /// From p to the nearest of the planes in its cube and up to two cubes away [m]; infinity if
  /// there is none.
  [[nodiscard]] double distance_to_planes_m(const geometry::Vec3& p_m) const;

  /// Number of the cube that holds p, if there is one.
  [[nodiscard]] std::optional<std::uint32_t> find(const geometry::Vec3& p_m) const {
    return index_.find(voxel_key(p_m, kSide_m));
  }

 private:
  struct Plane {
    double thickness_m = -1.0;                       ///< negative: none
    geometry::Vec3 mean_m = geometry::Vec3::Zero();  ///< offset from the corner
    geometry::Vec3 normal = geometry::Vec3::Zero();
  };

  [[nodiscard]] static Plane plane_of(const Voxel& voxel);

  VoxelIndex index_;
  std::vector<Voxel> voxels_;
};

/// Thickness of the walls of a map: a measure of its consistency that needs no ground truth.
struct Thickness {
  double median_m = 0.0;  ///< of sqrt(l3) over the cubes of 0.4 m that hold a plane
  double p95_m = 0.0;     ///< 95 % are thinner; doubled walls raise it
  std::size_t planes = 0;
};

/// Source: algorithms_fleet section 12. Zero planes give zeros. Compare only maps of one voxel
/// size.
[[nodiscard]] Thickness wall_thickness(const MapCloud& cloud);

}  // namespace rali::map
