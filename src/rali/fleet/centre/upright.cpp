#include "rali/fleet/centre/upright.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace rali::fleet {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// At 45 degrees a wall is as close to z of odom as the floor.
constexpr double kMax_deg = 40.0;
constexpr double kCoarse_deg = 8.0, kFine_deg = 3.0;
constexpr std::size_t kTried = 300;
/// Fractions of the surface that must be level or upright, and level alone.
constexpr double kOrderly = 0.5, kLevel = 0.1;
constexpr int kIterations = 10;

/// A surface patch: its normal in odom and its size.
struct Surface {
  Vec3 n = Vec3::UnitZ();
  double weight = 0.0;
};

std::vector<Surface> surfaces_of(std::span<const PathSubmap> pieces) {
  std::vector<Surface> out;
  for (const PathSubmap& piece : pieces) {
    for (const places::Plane& plane : piece.submap.planes()) {
      out.push_back({piece.T_odom_ref.R * plane.n, plane.radius_m * plane.radius_m});
    }
  }
  return out;
}

/// Amounts of level and of upright surface for a given up direction.
struct Order {
  double level = 0.0, walls = 0.0;
  Mat3 spread = Mat3::Zero();  ///< of level normals minus that of walls: up is its largest axis
};

Order order_of(const std::vector<Surface>& surfaces, const Vec3& up, double gate_deg) {
  const double level = std::cos(gate_deg * kDegree);
  const double wall = std::sin(gate_deg * kDegree);
  Order out;
  for (const Surface& s : surfaces) {
    const double along = std::abs(s.n.dot(up));
    if (along > level) {
      out.level += s.weight;
      out.spread += s.weight * s.n * s.n.transpose();
    } else if (along < wall) {
      out.walls += s.weight;
      out.spread -= s.weight * s.n * s.n.transpose();
    }
  }
  return out;
}

/// The normal that makes the most surface level or upright.
Vec3 best_normal(const std::vector<Surface>& surfaces) {
  Vec3 best = Vec3::UnitZ();
  double maximum = 0.0;
  const std::size_t stride = surfaces.size() / kTried + 1;
  for (std::size_t i = 0; i < surfaces.size(); i += stride) {
    const Vec3 up = surfaces[i].n.z() < 0.0 ? Vec3(-surfaces[i].n) : surfaces[i].n;
    if (up.z() < std::cos(kMax_deg * kDegree)) continue;
    const Order order = order_of(surfaces, up, kCoarse_deg);
    if (order.level + order.walls <= maximum) continue;
    maximum = order.level + order.walls;
    best = up;
  }
  return best;
}

}  // namespace

std::optional<Vec3> up_by_surfaces(std::span<const PathSubmap> pieces) {
  const std::vector<Surface> surfaces = surfaces_of(pieces);
  double all = 0.0;
  for (const Surface& s : surfaces) all += s.weight;
  Vec3 up = best_normal(surfaces);
  for (int k = 0; k < kIterations; ++k) {
    const Order order = order_of(surfaces, up, k < kIterations / 2 ? kCoarse_deg : kFine_deg);
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(order.spread);
    const Vec3 axis = solver.eigenvectors().col(2);
    up = axis.dot(up) < 0.0 ? Vec3(-axis) : axis;
  }
  const Order order = order_of(surfaces, up, kFine_deg);
  const bool orderly = order.level + order.walls > kOrderly * all && order.level > kLevel * all;
  if (!orderly || up.z() < std::cos(kMax_deg * kDegree)) return std::nullopt;
  return up;
}

std::vector<VehiclePath> upright(std::span<const VehiclePath> paths, const CutSettings& cut,
                                 const places::PlacesSettings& places, Executor& executor) {
  std::vector<VehiclePath> out;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].levelled()) continue;
    const auto pieces = cut_into_submaps(paths.subspan(i, 1), cut, places, executor);
    const std::optional<Vec3> up = up_by_surfaces(pieces);
    if (!up) continue;
    if (out.empty()) out.assign(paths.begin(), paths.end());
    out[i].set_up_odom(*up);
  }
  return out;
}

}  // namespace rali::fleet
