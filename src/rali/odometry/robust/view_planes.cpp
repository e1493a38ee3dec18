#include "rali/odometry/robust/view_planes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::odometry {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr int kRows = 30, kColumns = 60;  // three rings of a LiDAR with 16
constexpr double kCell_rad = std::numbers::pi / kRows;
constexpr double kRangeMin_m = 0.3;
/// Farther away the rings have covered the map's cells. A chosen value; others were not tested.
constexpr double kReach_m = 0.5;
constexpr double kReach_rad = 0.17;

/// Points of a cell of directions relative to the first of them.
struct Cell {
  PointSums sums;
  Vec3 origin_odom_m = Vec3::Zero();
};

}  // namespace

int ViewPlanes::cell_of(const Vec3& p_odom_m) const {
  const Vec3 p = T_odom_lidar_.R.transpose() * (p_odom_m - T_odom_lidar_.p);
  const double range_m = p.norm();
  if (!(range_m > kRangeMin_m)) return -1;
  const double up = std::asin(std::clamp(p.z() / range_m, -1.0, 1.0)) / std::numbers::pi + 0.5;
  const double turn = std::atan2(p.y(), p.x()) / (2.0 * std::numbers::pi) + 0.5;
  const int row = std::clamp(static_cast<int>(up * kRows), 0, kRows - 1);
  const int column = std::clamp(static_cast<int>(turn * kColumns), 0, kColumns - 1);
  return row * kColumns + column;
}

ViewPlanes::ViewPlanes(const std::vector<Vec3>& points_odom, const SE3& T_odom_lidar, double epoch,
                       const PlaneSettings& settings)
    : T_odom_lidar_(T_odom_lidar), plane_of_cell_(kRows * kColumns, -1) {
  // Noise along a ray never leaves its cell: no point is near a face.
  constexpr double kNoFaces_m = 1e6;
  std::vector<Cell> cells(plane_of_cell_.size());
  for (const Vec3& p : points_odom) {
    const int index = cell_of(p);
    if (index < 0) continue;
    Cell& cell = cells[static_cast<std::size_t>(index)];
    if (cell.sums.n == 0) cell.origin_odom_m = p;
    const Vec3 ray = (p - T_odom_lidar.p).normalized();
    cell.sums.add(p - cell.origin_odom_m, ray.cast<float>(), epoch, kNoFaces_m);
  }
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Cell& cell = cells[k];
    if (cell.sums.n < settings.points_min) continue;
    const Vec3 mean = cell.origin_odom_m + cell.sums.sum / cell.sums.n;
    const double edge_m = kCell_rad * (mean - T_odom_lidar.p).norm();
    Plane plane;
    const FitResult fit = fit_plane(cell.sums, cell.origin_odom_m, edge_m, false, settings, plane);
    if (fit != FitResult::kPlane) continue;
    plane_of_cell_[k] = static_cast<int>(planes_.size());
    planes_.push_back(plane);
  }
}

int ViewPlanes::find(const Vec3& p_odom_m) const {
  const int cell = cell_of(p_odom_m);
  return cell < 0 ? -1 : plane_of_cell_[static_cast<std::size_t>(cell)];
}

bool ViewPlanes::is_left(const SE3& T_odom_lidar) const {
  const geometry::Vec6 moved = geometry::boxminus(T_odom_lidar, T_odom_lidar_);
  return moved.tail<3>().norm() > kReach_m || moved.head<3>().norm() > kReach_rad;
}

}  // namespace rali::odometry
