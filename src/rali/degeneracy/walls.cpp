#include "rali/degeneracy/walls.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rali/degeneracy/support.hpp"

namespace rali::degeneracy {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

struct Facing {
  const PlaneEvidence* plane;
  double along;     ///< of its normal and the motion of its points
  double variance;  ///< of that
};

/// Planes whose points the motion moves off them, beyond the noise of their normals.
std::vector<Facing> planes_facing(const Vec6& motion, std::span<const PlaneEvidence> planes,
                                  const Mat3& R_odom_body) {
  const Vec3 turn_odom = R_odom_body * motion.head<3>();
  std::vector<Facing> out;
  for (const PlaneEvidence& plane : planes) {
    const Vec3 moved = motion.tail<3>() + turn_odom.cross(plane.lever_odom_m);
    const double along = plane.n_odom.dot(moved);
    const double variance = moved.dot(plane.normal_covariance * moved);
    if (faces(along, variance)) out.push_back({&plane, along, variance});
  }
  return out;
}

bool lie_in_one(const PlaneEvidence& a, const PlaneEvidence& b) {
  constexpr double kCosineMin = 0.95;  // normals of far planes have sigmas of up to 10 degrees
  constexpr double kApart_m = 0.25;
  if (std::abs(a.n_odom.dot(b.n_odom)) < kCosineMin) return false;
  const Vec3 between_m = b.lever_odom_m - a.lever_odom_m;
  return std::abs(a.n_odom.dot(between_m)) < kApart_m &&
         std::abs(b.n_odom.dot(between_m)) < kApart_m;
}

}  // namespace

WallHold walls_facing(const Vec6& motion, std::span<const PlaneEvidence> planes,
                      const Mat3& R_odom_body) {
  constexpr int kPartsMin = 3;
  const std::vector<Facing> facing = planes_facing(motion, planes, R_odom_body);
  WallHold out;
  double gradient = 0.0;  // of half the squared residuals
  for (const Facing& f : facing) {
    const auto in_one = [&f](const Facing& other) { return lie_in_one(*f.plane, *other.plane); };
    if (std::count_if(facing.begin(), facing.end(), in_one) < kPartsMin) continue;
    out.raw += f.plane->weight * f.along * f.along;
    out.noise += f.plane->weight * f.variance;
    gradient += f.plane->weight * f.along * f.plane->residual_m;
  }
  if (out.raw > 0.0) out.residual_m = gradient / out.raw;
  return out;
}

}  // namespace rali::degeneracy
