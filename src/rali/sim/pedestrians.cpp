#include "rali/sim/pedestrians.hpp"

#include <cmath>
#include <numbers>

namespace rali::sim {

using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr float kClothes_refl = 0.4F;

/// Ray against an upright cylinder without lids.
void meet_cylinder(const Vec3& origin, const Vec3& d, const Vec2& centre, double radius_m,
                   double z0, double z1, Hit& hit) {
  const Vec2 to = origin.head<2>() - centre;
  const double a = d.head<2>().squaredNorm();
  if (a < 1e-12) return;
  const double b = to.dot(d.head<2>());
  const double c = to.squaredNorm() - radius_m * radius_m;
  const double disc = b * b - a * c;
  if (disc <= 0.0 || c < 0.0) return;
  const double range = (-b - std::sqrt(disc)) / a;
  if (range <= 0.0 || (hit.range_m > 0.0F && range >= static_cast<double>(hit.range_m))) return;
  const double z = origin.z() + range * d.z();
  if (z < z0 || z > z1) return;
  const Vec2 normal = (to + range * d.head<2>()) / radius_m;
  hit = {static_cast<float>(range), static_cast<float>(std::abs(normal.dot(d.head<2>()))),
         kClothes_refl};
}

void meet_ball(const Vec3& origin, const Vec3& d, const Vec3& centre, double radius_m, Hit& hit) {
  const Vec3 to = origin - centre;
  const double b = to.dot(d);
  const double c = to.squaredNorm() - radius_m * radius_m;
  const double disc = b * b - c;
  if (disc <= 0.0 || c < 0.0) return;
  const double range = -b - std::sqrt(disc);
  if (range <= 0.0 || (hit.range_m > 0.0F && range >= static_cast<double>(hit.range_m))) return;
  const Vec3 normal = (to + range * d) / radius_m;
  hit = {static_cast<float>(range), static_cast<float>(std::abs(normal.dot(d))), kClothes_refl};
}

}  // namespace

Pedestrians::Pedestrians(const Route& route, int count, double free_width_m, std::uint64_t seed)
    : route_(&route) {
  Rng rng(seed, "pedestrians");
  for (int i = 0; i < count; ++i) {
    Person p{};
    p.middle_m = rng.uniform(0.1, 0.9) * route.length_m();
    p.reach_m = rng.uniform(6.0, 20.0);
    p.speed_mps = rng.uniform(0.7, 1.6);
    p.phase_s = rng.uniform(0.0, 60.0);
    p.side_m = (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(0.6, 1.0) * free_width_m;
    people_.push_back(p);
  }
}

void Pedestrians::place_at(double t_s) {
  for (Person& p : people_) {
    // A sinusoid with the given top speed: turning round takes a while, as with people.
    const double w = p.speed_mps / p.reach_m;
    const double s = p.middle_m + p.reach_m * std::sin(w * (t_s + p.phase_s));
    const double yaw = route_->yaw_at(s);
    const Vec3 ahead(std::cos(yaw), std::sin(yaw), 0.0);
    const Vec3 left(-ahead.y(), ahead.x(), 0.0);
    p.feet = route_->point_at(s) + p.side_m * left;
    const double stride = 0.28 * std::sin(2.0 * std::numbers::pi * 0.7 * s);
    p.leg_left = (p.feet + stride * ahead + 0.1 * left).head<2>();
    p.leg_right = (p.feet - stride * ahead - 0.1 * left).head<2>();
  }
}

void Pedestrians::cast(const Vec3& origin, const Vec3& direction, Hit& hit) const {
  constexpr double kWidest_m = 0.6;
  const Vec2 flat = direction.head<2>();
  for (const Person& p : people_) {
    const Vec2 to = p.feet.head<2>() - origin.head<2>();
    // The ray's vertical plane passes nobody: by far the most frequent case.
    const double aside = to.x() * flat.y() - to.y() * flat.x();
    if (std::abs(aside) > kWidest_m || to.dot(flat) < -kWidest_m) continue;
    const double z = p.feet.z();
    meet_cylinder(origin, direction, p.leg_left, 0.09, z, z + 0.85, hit);
    meet_cylinder(origin, direction, p.leg_right, 0.09, z, z + 0.85, hit);
    meet_cylinder(origin, direction, p.feet.head<2>(), 0.21, z + 0.8, z + 1.5, hit);
    meet_ball(origin, direction, p.feet + Vec3(0.0, 0.0, 1.64), 0.12, hit);
  }
}

std::vector<Vec3> Pedestrians::positions() const {
  std::vector<Vec3> out;
  for (const Person& p : people_) out.push_back(p.feet);
  return out;
}

}  // namespace rali::sim
