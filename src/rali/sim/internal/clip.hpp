#pragma once

#include <array>

#include "rali/geometry/types.hpp"

namespace rali::sim::internal {

/// A convex polygon, clipped from a triangle by planes x, y or z = constant.
struct ClipPolygon {
  // Each cut adds at most one corner: six cuts of a triangle give nine.
  std::array<geometry::Vec3, 12> corners;
  int size = 0;

  void add(const geometry::Vec3& p) { corners[static_cast<std::size_t>(size++)] = p; }

  [[nodiscard]] const geometry::Vec3& at(int i) const {
    return corners[static_cast<std::size_t>(i)];
  }
};

/// The part of `in` with sign * p[axis] <= sign * limit (Sutherland and Hodgman 1974); points that
/// only touch the plane are kept.
[[nodiscard]] inline ClipPolygon clipped(const ClipPolygon& in, int axis, double limit,
                                         double sign) {
  ClipPolygon out;
  for (int i = 0; i < in.size; ++i) {
    const geometry::Vec3& a = in.at(i);
    const geometry::Vec3& b = in.at((i + 1) % in.size);
    const double da = sign * (a[axis] - limit);
    const double db = sign * (b[axis] - limit);
    if (da <= 0.0) out.add(a);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) out.add(a + (b - a) * (da / (da - db)));
  }
  return out;
}

/// The part with low <= p[axis] <= high.
[[nodiscard]] inline ClipPolygon clipped_between(const ClipPolygon& in, int axis, double low,
                                                 double high) {
  return clipped(clipped(in, axis, high, 1.0), axis, low, -1.0);
}

}  // namespace rali::sim::internal
