#include "rali/sim/radio/obstruction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr std::size_t kMaxSurfaces = 32;
constexpr double kPairWithin_m = 0.5;

struct Surfaces {
  std::array<double, kMaxSurfaces> at_m{};  ///< distance from the start
  std::size_t count = 0;
};

Surfaces surfaces_between(const RayCaster& world, const Vec3& a, const Vec3& direction,
                          double distance) {
  // The next ray starts slightly behind the last surface, else it would hit it again.
  constexpr double kStep_m = 0.002;
  Surfaces s;
  double from = 0.0;
  while (from < distance && s.count < kMaxSurfaces) {
    const Hit hit = world.cast(a + from * direction, direction, distance - from);
    if (hit.range_m <= 0.0F) break;
    from += static_cast<double>(hit.range_m);
    s.at_m[s.count++] = from;
    from += kStep_m;
  }
  return s;
}

void add_pairs(const Surfaces& s, Obstruction& o) {
  for (std::size_t i = 0; i + 1 < s.count; i += 2) {
    ++o.walls;
    o.thickness_m += s.at_m[i + 1] - s.at_m[i];
  }
}

void add_sheets_and_pairs(const Surfaces& s, double sheet_m, Obstruction& o) {
  for (std::size_t i = 0; i < s.count; ++i) {
    const bool pair = i + 1 < s.count && s.at_m[i + 1] - s.at_m[i] < kPairWithin_m;
    ++o.walls;
    o.thickness_m += pair ? s.at_m[i + 1] - s.at_m[i] : sheet_m;
    if (pair) ++i;
  }
}

/// True if the line from a to b passes the axis of an upright cylinder within its radius, between
/// its ends.
bool crosses(const Vec3& a, const Vec3& b, const RadioBody& body) {
  const geometry::Vec2 line = (b - a).head<2>();
  const geometry::Vec2 to = (body.foot_m - a).head<2>();
  const double length2 = line.squaredNorm();
  const double u = length2 > 1e-12 ? std::clamp(to.dot(line) / length2, 0.0, 1.0) : 0.0;
  if ((u * line - to).norm() > body.radius_m) return false;
  const double z = a.z() + u * (b.z() - a.z());
  return z >= body.foot_m.z() && z <= body.foot_m.z() + body.height_m;
}

}  // namespace

Obstruction trace_line(const RayCaster& world, const Vec3& a, const Vec3& b,
                       double sheet_thickness_m, std::span<const RadioBody> bodies) {
  Obstruction o;
  const double distance = (b - a).norm();
  if (distance < 1e-6) return o;
  const Surfaces s = surfaces_between(world, a, (b - a) / distance, distance);
  if (s.count % 2 == 0) {
    add_pairs(s, o);
  } else {
    add_sheets_and_pairs(s, sheet_thickness_m, o);
  }
  for (const RadioBody& body : bodies) o.bodies += crosses(a, b, body) ? 1 : 0;
  return o;
}

}  // namespace rali::sim
