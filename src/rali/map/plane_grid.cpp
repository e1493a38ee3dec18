#include "rali/map/plane_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rali/geometry/pca3.hpp"

namespace rali::map {
namespace {

constexpr std::uint64_t kPointsMin = 10;
/// Smallest to middle eigenvalue of a plane (algorithms_fleet section 12).
constexpr double kFlatness = 0.1;
/// Minimum extent along the middle axis, or a pole would count as a plane.
constexpr double kWidthMin_m = 0.05;
/// Cubes per axis whose planes are near: two on either side.
constexpr int kAround = 5;

}  // namespace

void PlaneGrid::add(const geometry::Vec3& p_m) {
  const VoxelKey key = voxel_key(p_m, kSide_m);
  if (key == kNoVoxel) return;
  const VoxelIndex::Slot slot = index_.insert(key);
  if (slot.is_new) voxels_.emplace_back();
  Voxel& voxel = voxels_[slot.index];
  const geometry::Vec3 offset = p_m - voxel_corner(key, kSide_m);
  ++voxel.points;
  voxel.sum_m += offset;
  voxel.square_m2 += offset * offset.transpose();
}

PlaneGrid::Plane PlaneGrid::plane_of(const Voxel& voxel) {
  if (voxel.points < kPointsMin) return {};
  const auto n = static_cast<double>(voxel.points);
  const geometry::Vec3 mean = voxel.sum_m / n;
  const geometry::Pca3 pca = geometry::pca3(voxel.square_m2 / n - mean * mean.transpose());
  const double smallest = std::max(pca.values(2), 0.0);
  const bool plane =
      smallest < kFlatness * pca.values(1) && pca.values(1) > kWidthMin_m * kWidthMin_m;
  if (!plane) return {};
  return {std::sqrt(smallest), mean, pca.vectors.col(2)};
}

double PlaneGrid::plane_thickness_m(const Voxel& voxel) { return plane_of(voxel).thickness_m; }

double PlaneGrid::distance_to_planes_m(const geometry::Vec3& p_m) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kAround * kAround * kAround; ++i) {
    const geometry::Vec3 step =
        geometry::Vec3(i / (kAround * kAround), i / kAround % kAround, i % kAround) -
        geometry::Vec3::Constant(kAround / 2);
    const VoxelKey key = voxel_key(p_m + kSide_m * step, kSide_m);
    const auto number = index_.find(key);
    if (!number) continue;
    const Plane plane = plane_of(voxels_[*number]);
    if (plane.thickness_m < 0.0) continue;
    const geometry::Vec3 from_plane = p_m - voxel_corner(key, kSide_m) - plane.mean_m;
    nearest_m = std::min(nearest_m, std::abs(plane.normal.dot(from_plane)));
  }
  return nearest_m;
}

std::vector<std::optional<geometry::Vec3>> PlaneGrid::normals() const {
  std::vector<std::optional<geometry::Vec3>> normals;
  normals.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) {
    const Plane plane = plane_of(voxel);
    normals.push_back(plane.thickness_m < 0.0 ? std::nullopt : std::optional(plane.normal));
  }
  return normals;
}

Thickness wall_thickness(const MapCloud& cloud) {
  PlaneGrid grid;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    grid.add({static_cast<double>(cloud.x_m[i]), static_cast<double>(cloud.y_m[i]),
              static_cast<double>(cloud.z_m[i])});
  }
  std::vector<double> thickness_m;
  for (const PlaneGrid::Voxel& voxel : grid.voxels()) {
    const double t = PlaneGrid::plane_thickness_m(voxel);
    if (t >= 0.0) thickness_m.push_back(t);
  }
  if (thickness_m.empty()) return {};
  std::sort(thickness_m.begin(), thickness_m.end());
  const std::size_t n = thickness_m.size();
  return {thickness_m[n / 2], thickness_m[std::min(n * 95 / 100, n - 1)], n};
}

}  // namespace rali::map
