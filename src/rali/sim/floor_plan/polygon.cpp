#include "rali/sim/floor_plan/polygon.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace rali::sim {

using geometry::Vec2;

namespace {

constexpr double kFarthest_m = 1e5;
constexpr double kSame_m = 1e-6;

double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_m2(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross2(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return 0.5 * std::abs(twice);
}

/// True if the segments a-b and c-d share a point.
bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const auto side = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    const double value = cross2(q - p, r - p);
    return std::abs(value) < 1e-12 ? 0 : (value > 0.0 ? 1 : -1);
  };
  const auto within = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return (r.array() >= p.cwiseMin(q).array()).all() && (r.array() <= p.cwiseMax(q).array()).all();
  };
  const int s1 = side(a, b, c);
  const int s2 = side(a, b, d);
  const int s3 = side(c, d, a);
  const int s4 = side(c, d, b);
  if (s1 != s2 && s3 != s4 && s1 * s2 <= 0 && s3 * s4 <= 0) return true;
  return (s1 == 0 && within(a, b, c)) || (s2 == 0 && within(a, b, d)) ||
         (s3 == 0 && within(c, d, a)) || (s4 == 0 && within(c, d, b));
}

}  // namespace

std::string polygon_fault(const Polygon& polygon) {
  const std::size_t n = polygon.size();
  for (const Vec2& p : polygon) {
    if (!p.allFinite()) return "has a corner that is no number";
    if (p.cwiseAbs().maxCoeff() > kFarthest_m) {
      return fmt::format("has a corner at [{:.6g}, {:.6g}], more than {} km away", p.x(), p.y(),
                         kFarthest_m / 1000.0);
    }
  }
  if (n < 3) return fmt::format("has {} corners; an area has at least 3", n);
  for (std::size_t i = 0; i < n; ++i) {
    if ((polygon[(i + 1) % n] - polygon[i]).norm() < kSame_m) {
      return fmt::format("has the corner [{:.6g}, {:.6g}] twice", polygon[i].x(), polygon[i].y());
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;  // neighbours share a corner
      if (!meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % n])) continue;
      return fmt::format(
          "crosses itself: the edges from [{:.6g}, {:.6g}] and [{:.6g}, {:.6g}] meet",
          polygon[i].x(), polygon[i].y(), polygon[j].x(), polygon[j].y());
    }
  }
  if (area_m2(polygon) < 1e-4) return "has no area";
  return {};
}

bool is_inside(const Polygon& polygon, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2& a = polygon[i];
    const Vec2& b = polygon[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

Polygon rectangle(const Vec2& middle, const Vec2& size_m, double yaw_rad) {
  const Vec2 u = 0.5 * size_m.x() * Vec2(std::cos(yaw_rad), std::sin(yaw_rad));
  const Vec2 v = 0.5 * size_m.y() * Vec2(-std::sin(yaw_rad), std::cos(yaw_rad));
  return {middle - u - v, middle + u - v, middle + u + v, middle - u + v};
}

Polygon rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

}  // namespace rali::sim
