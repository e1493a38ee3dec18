#include "rali/sim/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rali/sim/internal/clip.hpp"

namespace rali::sim {

using geometry::Vec2;
using geometry::Vec3;
using internal::ClipPolygon;

namespace {

constexpr double kBin_m = 1.0;
constexpr double kBinsMax = 4.0e6;

double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance_to_edge(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a;
  const double squared = ab.squaredNorm();
  const double u = squared > 0.0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (p - a - u * ab).norm();
}

/// Distance in the plan view; 0 inside the polygon.
double distance_to_polygon(const Vec2& p, const ClipPolygon& polygon) {
  double nearest = std::numeric_limits<double>::infinity();
  bool left = true;
  bool right = true;
  for (int i = 0; i < polygon.size; ++i) {
    const Vec2 a = polygon.at(i).head<2>();
    const Vec2 b = polygon.at((i + 1) % polygon.size).head<2>();
    nearest = std::min(nearest, distance_to_edge(p, a, b));
    const double side = cross2(b - a, p - a);
    left = left && side > 0.0;
    right = right && side < 0.0;
  }
  return polygon.size > 2 && (left || right) ? 0.0 : nearest;
}

struct Corners {
  Vec3 a, b, c;

  Corners(const TriangleMesh& mesh, std::uint32_t triangle) {
    const std::array<std::uint32_t, 3>& t = mesh.triangles[triangle];
    a = mesh.vertices[t[0]].cast<double>();
    b = mesh.vertices[t[1]].cast<double>();
    c = mesh.vertices[t[2]].cast<double>();
  }
};

}  // namespace

Clearance::Clearance(const TriangleMesh& mesh) : mesh_(&mesh) {
  const Vec2 high = mesh.upper_corner().head<2>();
  low_ = mesh.lower_corner().head<2>();
  const Vec2 size = high - low_;
  bin_m_ = std::max({kBin_m, std::sqrt(std::max(size.x() * size.y(), 0.0) / kBinsMax),
                     size.maxCoeff() / kBinsMax});
  bins_x_ = static_cast<std::int64_t>(size.x() / bin_m_) + 1;
  bins_y_ = static_cast<std::int64_t>(size.y() / bin_m_) + 1;
  // Two passes: count, then fill.
  begin_.assign(static_cast<std::size_t>(bins_x_ * bins_y_) + 1, 0);
  const auto each_bin = [&](const auto& use) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Corners k(mesh, t);
      const Vec3 low = k.a.cwiseMin(k.b).cwiseMin(k.c);
      const Vec3 top = k.a.cwiseMax(k.b).cwiseMax(k.c);
      for (std::int64_t y = bin_of(low.y(), 1); y <= bin_of(top.y(), 1); ++y) {
        for (std::int64_t x = bin_of(low.x(), 0); x <= bin_of(top.x(), 0); ++x) {
          use(static_cast<std::size_t>(y * bins_x_ + x), t);
        }
      }
    }
  };
  each_bin([&](std::size_t bin, std::uint32_t) { ++begin_[bin + 1]; });
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  triangles_.resize(begin_.back());
  std::vector<std::uint32_t> fill(begin_.begin(), begin_.end() - 1);
  each_bin([&](std::size_t bin, std::uint32_t t) { triangles_[fill[bin]++] = t; });
}

std::int64_t Clearance::bin_of(double value, int axis) const {
  const double bin = std::floor((value - low_[axis]) / bin_m_);
  return static_cast<std::int64_t>(
      std::clamp(bin, 0.0, static_cast<double>((axis == 0 ? bins_x_ : bins_y_) - 1)));
}

template <class Use>
void Clearance::visit_near(double x_m, double y_m, double half_m, const Use& use) const {
  for (std::int64_t y = bin_of(y_m - half_m, 1); y <= bin_of(y_m + half_m, 1); ++y) {
    for (std::int64_t x = bin_of(x_m - half_m, 0); x <= bin_of(x_m + half_m, 0); ++x) {
      const auto bin = static_cast<std::size_t>(y * bins_x_ + x);
      for (std::uint32_t i = begin_[bin]; i < begin_[bin + 1]; ++i) use(triangles_[i]);
    }
  }
}

double Clearance::distance_m(const Vec3& ground, const VehicleShape& shape, double limit_m) const {
  double nearest = limit_m;
  const Vec2 p = ground.head<2>();
  const double low = ground.z() + shape.low_m;
  const double high = ground.z() + shape.high_m;
  visit_near(p.x(), p.y(), limit_m, [&](std::uint32_t t) {
    const Corners k(*mesh_, t);
    if (std::max({k.a.z(), k.b.z(), k.c.z()}) < low) return;
    if (std::min({k.a.z(), k.b.z(), k.c.z()}) > high) return;
    ClipPolygon polygon;
    polygon.add(k.a);
    polygon.add(k.b);
    polygon.add(k.c);
    polygon = internal::clipped_between(polygon, 2, low, high);
    if (polygon.size > 0) nearest = std::min(nearest, distance_to_polygon(p, polygon));
  });
  return nearest;
}

std::optional<Vec3> Clearance::first_contact(const std::vector<Vec3>& path,
                                             const VehicleShape& shape) const {
  constexpr double kStep_m = 0.1;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec3 step = path[i + 1] - path[i];
    const int n = std::max(1, static_cast<int>(std::ceil(step.norm() / kStep_m)));
    for (int k = 0; k <= n; ++k) {
      const Vec3 p = path[i] + step * (static_cast<double>(k) / n);
      if (!free_at(p, shape)) return p;
    }
  }
  return std::nullopt;
}

std::vector<double> Clearance::surfaces_at(double x_m, double y_m) const {
  std::vector<double> heights;
  const Vec2 p(x_m, y_m);
  visit_near(x_m, y_m, 0.0, [&](std::uint32_t t) {
    const Corners k(*mesh_, t);
    const Vec2 a = k.a.head<2>();
    const Vec2 ab = k.b.head<2>() - a;
    const Vec2 ac = k.c.head<2>() - a;
    const double area = cross2(ab, ac);
    if (std::abs(area) < 1e-12) return;
    const double u = cross2(p - a, ac) / area;
    const double v = cross2(ab, p - a) / area;
    if (u < -1e-9 || v < -1e-9 || u + v > 1.0 + 1e-9) return;
    heights.push_back(k.a.z() + u * (k.b.z() - k.a.z()) + v * (k.c.z() - k.a.z()));
  });
  std::sort(heights.begin(), heights.end());
  return heights;
}

std::optional<double> Clearance::ground_below(double x_m, double y_m, double from_z_m,
                                              double depth_m) const {
  std::optional<double> best;
  for (const double z : surfaces_at(x_m, y_m)) {
    if (z <= from_z_m && z >= from_z_m - depth_m) best = z;
  }
  return best;
}

}  // namespace rali::sim
