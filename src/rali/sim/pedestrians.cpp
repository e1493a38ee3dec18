#include "rali/sim/pedestrians.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/sim/vehicle_look.hpp"

namespace rali::sim {

using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr float kClothes_refl = 0.4F;

/// Intersection of a ray with an upright cylinder without caps.
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

Pedestrians::Pedestrians(const Route& route, const Crowd& crowd, double free_width_m,
                         std::uint64_t seed)
    : route_(&route) {
  Rng rng(seed, "pedestrians");
  for (int i = 0; i < crowd.walking; ++i) {
    Person p{};
    p.middle_m = rng.uniform(0.1, 0.9) * route.length_m();
    p.reach_m = rng.uniform(6.0, 20.0);
    p.speed_mps = rng.uniform(0.7, 1.6);
    p.phase_s = rng.uniform(0.0, 60.0);
    p.side_m = (rng.uniform() < 0.5 ? -1.0 : 1.0) * rng.uniform(0.6, 1.0) * free_width_m;
    people_.push_back(p);
  }
  Rng others(seed, "people who stand or cross");
  for (int i = 0; i < crowd.standing + crowd.crossing; ++i) {
    Person p{};
    p.crosses = i >= crowd.standing;
    p.middle_m = others.uniform(0.0, 1.0) * route.length_m();
    p.speed_mps = p.crosses ? others.uniform(0.7, 1.6) : 0.0;
    p.phase_s = others.uniform(0.0, 60.0);
    p.side_m = (others.uniform() < 0.5 ? -1.0 : 1.0) * others.uniform(0.8, 1.0) * free_width_m;
    people_.push_back(p);
  }
}

void Pedestrians::add_escort(const Escort& escort, const Trajectory& trajectory,
                             double body_height_m) {
  Companion companion{};
  companion.escort = escort;
  companion.trajectory = &trajectory;
  companion.body_height_m = body_height_m;
  escorts_.push_back(companion);
}

void Pedestrians::put(Body& body, const Vec3& feet, const Vec3& ahead, double walked_m) {
  const Vec3 left(-ahead.y(), ahead.x(), 0.0);
  const double stride = 0.28 * std::sin(2.0 * std::numbers::pi * 0.7 * walked_m);
  body.feet = feet;
  body.leg_left = (feet + stride * ahead + 0.1 * left).head<2>();
  body.leg_right = (feet - stride * ahead - 0.1 * left).head<2>();
}

/// Places the companion on the vehicle's own path, gap_m ahead of it.
void Pedestrians::place(Companion& companion, double t_s) const {
  const Escort& e = companion.escort;
  const Trajectory& path = *companion.trajectory;
  const double s = path.distance_m(std::clamp(t_s, e.start_s, e.end_s)) + e.gap_m;
  geometry::SE3 T = path.pose_at(path.time_at_distance_s(std::max(0.0, s)));
  const double yaw = std::atan2(T.R(1, 0), T.R(0, 0));
  const Vec3 ahead(std::cos(yaw), std::sin(yaw), 0.0);
  // Beyond the ends of the path, extrapolate in a straight line.
  T.p += ahead * (std::min(0.0, s) + std::max(0.0, s - path.distance_m(path.duration_s())));
  T.p += e.side_m * Vec3(-ahead.y(), ahead.x(), 0.0);
  companion.T_world_cart = T;
  put(companion, T.p - Vec3(0.0, 0.0, companion.body_height_m), ahead, s);
}

void Pedestrians::place_at(double t_s) {
  for (Person& p : people_) {
    // A sinusoid with the given top speed, because people take time to turn round.
    const double reach_m = p.crosses ? std::max(0.1, std::abs(p.side_m)) : p.reach_m;
    const double swing_m =
        p.speed_mps > 0.0 ? reach_m * std::sin(p.speed_mps / reach_m * (t_s + p.phase_s)) : 0.0;
    const double s = p.middle_m + (p.crosses ? 0.0 : swing_m);
    const double yaw = route_->yaw_at(s);
    const Vec3 ahead(std::cos(yaw), std::sin(yaw), 0.0);
    const Vec3 left(-ahead.y(), ahead.x(), 0.0);
    const double side_m = p.crosses ? swing_m : p.side_m;
    put(p, route_->point_at(s) + side_m * left, p.crosses ? left : ahead, p.crosses ? swing_m : s);
  }
  for (Companion& companion : escorts_) place(companion, t_s);
}

void Pedestrians::cast_body(const Body& body, const Vec3& origin, const Vec3& direction, Hit& hit) {
  const double z = body.feet.z();
  meet_cylinder(origin, direction, body.leg_left, 0.09, z, z + 0.85, hit);
  meet_cylinder(origin, direction, body.leg_right, 0.09, z, z + 0.85, hit);
  meet_cylinder(origin, direction, body.feet.head<2>(), 0.21, z + 0.8, z + 1.5, hit);
  meet_ball(origin, direction, body.feet + Vec3(0.0, 0.0, 1.64), 0.12, hit);
}

void Pedestrians::cast(const Vec3& origin, const Vec3& direction, Hit& hit) const {
  constexpr double kWidest_m = 0.6;
  const Vec2 flat = direction.head<2>();
  const auto passes = [&](const Body& body) {
    const Vec2 to = body.feet.head<2>() - origin.head<2>();
    // The ray's vertical plane misses the person: by far the most frequent case.
    const double lateral = to.x() * flat.y() - to.y() * flat.x();
    return std::abs(lateral) > kWidest_m || to.dot(flat) < -kWidest_m;
  };
  for (const Person& p : people_) {
    if (!passes(p)) cast_body(p, origin, direction, hit);
  }
  for (const Companion& c : escorts_) {
    if (c.escort.cart) {
      meet_vehicle(VehicleLook{}, c.T_world_cart, origin, direction, hit);
    } else if (!passes(c)) {
      cast_body(c, origin, direction, hit);
    }
  }
}

std::vector<Vec3> Pedestrians::positions() const {
  std::vector<Vec3> out;
  for (const Person& p : people_) out.push_back(p.feet);
  for (const Companion& c : escorts_) out.push_back(c.feet);
  return out;
}

}  // namespace rali::sim
