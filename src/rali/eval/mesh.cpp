#include "rali/eval/mesh.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace rali::eval {

using geometry::Vec3;

namespace {

constexpr double kFarthest_m = 1e9;

double triangle_area_m2(const TriangleMesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return 0.5 *
         (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
}

/// Point number k of a sequence that fills a triangle evenly (additive recurrence with the two
/// powers of the plastic number's inverse), folded into the triangle.
Vec3 point_in(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;
  const double n = static_cast<double>(k) + 1.0;
  double u = n * kStepU - std::floor(n * kStepU);
  double v = n * kStepV - std::floor(n * kStepV);
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3& corner = mesh.vertices[a];
  return corner + u * (mesh.vertices[b] - corner) + v * (mesh.vertices[c] - corner);
}

}  // namespace

Status check_mesh(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.empty()) {
    return fail(ErrorCode::kInput, name, "has no triangles",
                "A mesh with faces is needed; a point cloud is none.");
  }
  if (mesh.triangles.size() > (std::size_t{1} << 31)) {
    return fail(ErrorCode::kInput, name, "has more than 2147483648 triangles");
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!mesh.vertices[v].allFinite()) {
      return fail(ErrorCode::kInput, name, fmt::format("vertex {} is no finite point", v));
    }
    if (mesh.vertices[v].cwiseAbs().maxCoeff() > kFarthest_m) {
      return fail(ErrorCode::kInput, name,
                  fmt::format("vertex {} lies more than {:g} m from the origin", v, kFarthest_m),
                  "Coordinates are metres.");
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v < mesh.vertices.size()) continue;
      return fail(
          ErrorCode::kInput, name,
          fmt::format("triangle {} names vertex {}, but there are {}", t, v, mesh.vertices.size()));
    }
  }
  return {};
}

double area_m2(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += triangle_area_m2(mesh, t);
  return area;
}

std::vector<Vec3> sample_surface(const TriangleMesh& mesh, double spacing_m, std::size_t at_most) {
  std::vector<Vec3> points;
  const double area = area_m2(mesh);
  if (!(area > 0.0) || !(spacing_m > 0.0) || !std::isfinite(area) || at_most == 0) return points;
  const double wanted =
      std::clamp(std::round(area / (spacing_m * spacing_m)), 1.0, static_cast<double>(at_most));
  points.reserve(static_cast<std::size_t>(wanted));
  const double step = area / wanted;
  double after = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    after += triangle_area_m2(mesh, t);
    while (static_cast<double>(points.size()) < wanted &&
           (static_cast<double>(points.size()) + 0.5) * step < after) {
      points.push_back(point_in(mesh, t, points.size()));
    }
  }
  return points;
}

}  // namespace rali::eval
