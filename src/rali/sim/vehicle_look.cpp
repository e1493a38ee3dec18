#include "rali/sim/vehicle_look.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rali::sim {

using geometry::SE3;
using geometry::Vec2;
using geometry::Vec3;

namespace {

bool nearer(double range_m, const Hit& hit) {
  return range_m > 0.0 && (hit.range_m <= 0.0F || range_m < static_cast<double>(hit.range_m));
}

/// Intersection of a ray with an axis-aligned box (slabs; Kay, Kajiya 1986). A ray from inside hits
/// nothing.
void meet_box(const Vec3& low, const Vec3& high, const Vec3& o, const Vec3& d, float refl,
              Hit& hit) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  Eigen::Index face = 0;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (std::abs(d[k]) < 1e-12) {
      if (o[k] < low[k] || o[k] > high[k]) return;
      continue;
    }
    const double a = (low[k] - o[k]) / d[k];
    const double b = (high[k] - o[k]) / d[k];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      face = k;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || !nearer(enter, hit)) return;
  hit = {static_cast<float>(enter), static_cast<float>(std::abs(d[face])), refl};
}

/// Intersection of a ray with the side of an upright cylinder.
void meet_mast(const VehicleLook& look, const Vec3& o, const Vec3& d, Hit& hit) {
  const Vec2 to = o.head<2>() - look.mast_m;
  const double a = d.head<2>().squaredNorm();
  const double b = to.dot(d.head<2>());
  const double c = to.squaredNorm() - look.mast_radius_m * look.mast_radius_m;
  const double disc = b * b - a * c;
  if (a < 1e-12 || disc <= 0.0 || c < 0.0) return;
  const double range = (-b - std::sqrt(disc)) / a;
  const double z = o.z() + range * d.z();
  if (!nearer(range, hit) || z < look.box_max_m.z() || z > look.mast_top_m) return;
  const Vec2 normal = (to + range * d.head<2>()) / look.mast_radius_m;
  hit = {static_cast<float>(range), static_cast<float>(std::abs(normal.dot(d.head<2>()))),
         look.reflectivity};
}

}  // namespace

void meet_vehicle(const VehicleLook& look, const SE3& T_world_body, const Vec3& origin,
                  const Vec3& direction, Hit& hit) {
  constexpr double kReach_m = 0.7;  // of every part from the body's origin
  const Vec3 to = T_world_body.p - origin;
  const double along = to.dot(direction);
  // The ray misses the vehicle: by far the most frequent case.
  if (along < -kReach_m || to.squaredNorm() - along * along > kReach_m * kReach_m) return;
  const Vec3 o = T_world_body.R.transpose() * -to;
  const Vec3 d = T_world_body.R.transpose() * direction;
  meet_box(look.box_min_m, look.box_max_m, o, d, look.reflectivity, hit);
  meet_mast(look, o, d, hit);
}

}  // namespace rali::sim
