#include "rali/inspect/ground_normal.hpp"

#include <span>

#include "rali/drive/input/extrinsics_check.hpp"

namespace rali::inspect {
namespace {

constexpr double kUpMin = 0.7;  ///< cosine of 45 degrees

}  // namespace

std::optional<geometry::Vec3> ground_normal(const sensor::LidarScan& scan) {
  std::optional<geometry::Vec3> ceiling;
  // Largest weight first. Normals point to the LiDAR: up from a floor, down from a ceiling.
  for (const drive::PlaneDirection& plane : drive::plane_directions(std::span(&scan, 1))) {
    if (plane.n_lidar.z() > kUpMin) return plane.n_lidar;
    if (plane.n_lidar.z() < -kUpMin && !ceiling) ceiling = plane.n_lidar;
  }
  return ceiling;
}

}  // namespace rali::inspect
