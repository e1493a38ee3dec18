#include "rali/degeneracy/support.hpp"

#include <array>
#include <cmath>

namespace rali::degeneracy {

using geometry::Vec3;

bool faces(double along, double variance) {
  constexpr double kCosineMin = 0.2;
  constexpr double kSigmas = 3.0;
  return std::abs(along) > kCosineMin && along * along > kSigmas * kSigmas * variance;
}

Support support_along(const Vec3& direction_odom, std::span<const PlaneEvidence> planes,
                      double cluster_m) {
  std::array<Vec3, kClustersMax> first;
  std::size_t clusters = 0;
  Support out;
  for (const PlaneEvidence& plane : planes) {
    const double variance = direction_odom.dot(plane.normal_covariance * direction_odom);
    if (!faces(plane.n_odom.dot(direction_odom), variance)) continue;
    ++out.planes;
    if (clusters == first.size()) continue;
    bool known = false;
    for (std::size_t k = 0; k < clusters && !known; ++k) {
      known = (first[k] - plane.lever_odom_m).squaredNorm() < cluster_m * cluster_m;
    }
    if (!known) first[clusters++] = plane.lever_odom_m;
  }
  out.clusters = static_cast<int>(clusters);
  return out;
}

}  // namespace rali::degeneracy
