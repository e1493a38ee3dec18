#include "rali/inspect/ground_normal.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "rali/base/rng.hpp"
#include "rali/geometry/pca3.hpp"

namespace rali::inspect {
namespace {

constexpr float kNear_m = 1.0F, kFar_m = 15.0F;
constexpr double kThickness_m = 0.06;
constexpr int kTrials = 200;
constexpr std::size_t kPointsMin = 100;
constexpr double kShareMin = 0.08;
constexpr double kUpMin = 0.7;         ///< cosine of 45 degrees
constexpr double kHeightMin_m = 0.15;  ///< the LiDAR over the ground

std::vector<geometry::Vec3> near_points(const sensor::LidarScan& scan) {
  std::vector<geometry::Vec3> points;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const geometry::Vec3f p{scan.x_m[i], scan.y_m[i], scan.z_m[i]};
    const float range_m = p.norm();
    if (range_m > kNear_m && range_m < kFar_m) points.push_back(p.cast<double>());
  }
  return points;
}

struct Plane {
  geometry::Vec3 normal = geometry::Vec3::UnitZ();
  double offset_m = 0.0;  ///< normal . p of its points
  std::size_t support = 0;
};

std::size_t support_of(const Plane& plane, const std::vector<geometry::Vec3>& points) {
  std::size_t n = 0;
  for (const geometry::Vec3& p : points) {
    n += std::abs(plane.normal.dot(p) - plane.offset_m) < kThickness_m ? 1U : 0U;
  }
  return n;
}

Plane refined(const Plane& plane, const std::vector<geometry::Vec3>& points) {
  geometry::Vec3 mean = geometry::Vec3::Zero();
  geometry::Mat3 square = geometry::Mat3::Zero();
  double n = 0.0;
  for (const geometry::Vec3& p : points) {
    if (std::abs(plane.normal.dot(p) - plane.offset_m) >= kThickness_m) continue;
    mean += p;
    square += p * p.transpose();
    n += 1.0;
  }
  mean /= n;
  Plane out;
  out.normal = geometry::pca3(square / n - mean * mean.transpose()).vectors.col(2);
  out.offset_m = out.normal.dot(mean);
  out.support = plane.support;
  return out;
}

}  // namespace

std::optional<geometry::Vec3> ground_normal(const sensor::LidarScan& scan) {
  const std::vector<geometry::Vec3> points = near_points(scan);
  if (points.size() < kPointsMin) return std::nullopt;
  Rng rng(1, "ground_normal");  // a fixed seed: the same scan gives the same plane
  Plane best;
  for (int trial = 0; trial < kTrials; ++trial) {
    const geometry::Vec3& a = points[rng.below(points.size())];
    const geometry::Vec3& b = points[rng.below(points.size())];
    const geometry::Vec3& c = points[rng.below(points.size())];
    const geometry::Vec3 cross = (b - a).cross(c - a);
    if (cross.norm() < 0.1) continue;
    Plane plane;
    plane.normal = cross.normalized();
    plane.offset_m = plane.normal.dot(a);
    if (std::abs(plane.normal.z()) < kUpMin || std::abs(plane.offset_m) < kHeightMin_m) continue;
    plane.support = support_of(plane, points);
    // A ceiling has as many points as a floor; the floor is nearer to a vehicle.
    const bool nearer = std::abs(plane.offset_m) < std::abs(best.offset_m);
    const auto gain = nearer ? plane.support * 2 : plane.support;
    if (gain > best.support) best = plane;
  }
  if (static_cast<double>(best.support) < kShareMin * static_cast<double>(points.size())) {
    return std::nullopt;
  }
  best = refined(best, points);
  // The LiDAR is above the ground: the origin lies on the side the normal points to.
  return best.offset_m > 0.0 ? geometry::Vec3(-best.normal) : best.normal;
}

}  // namespace rali::inspect
