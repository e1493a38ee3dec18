#include "rali/odometry/robust/scan_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::odometry {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr float kRangeMin_m = 0.3F;
/// A cell is 4 degrees wide: a surface at 60 degrees of incidence spreads by a tenth across it.
constexpr float kTolerance = 0.08F;
constexpr float kTolerance_m = 0.15F;
/// Minimum of occupied cells among a cell and its eight neighbours for its rays to contradict a
/// point.
constexpr int kSeenMin = 5;

}  // namespace

ScanView::ScanView(const BodyPoints& points_body, const Vec3& p_body_lidar)
    : cells_(static_cast<std::size_t>(kRows) * kColumns) {
  const Vec3f origin = p_body_lidar.cast<float>();
  points_.reserve(points_body.size());
  for (std::size_t i = 0; i < points_body.size(); ++i) {
    const Vec3f p = Vec3f(points_body.x_m[i], points_body.y_m[i], points_body.z_m[i]) - origin;
    const float range_m = p.norm();
    if (!(range_m > kRangeMin_m) || !std::isfinite(range_m)) continue;
    points_.push_back(p);
    Cell& cell = cells_[static_cast<std::size_t>(row_of(p, range_m) * kColumns + column_of(p))];
    cell.near_m = cell.far_m > 0.0F ? std::min(cell.near_m, range_m) : range_m;
    cell.far_m = std::max(cell.far_m, range_m);
  }
}

int ScanView::row_of(const Vec3f& p, float range_m) {
  const float up = std::asin(std::clamp(p.z() / range_m, -1.0F, 1.0F));
  const float row = (up / std::numbers::pi_v<float> + 0.5F) * kRows;
  return std::clamp(static_cast<int>(row), 0, kRows - 1);
}

int ScanView::column_of(const Vec3f& p) {
  const float turn = std::atan2(p.y(), p.x()) / (2.0F * std::numbers::pi_v<float>)+0.5F;
  return std::clamp(static_cast<int>(turn * kColumns), 0, kColumns - 1);
}

void ScanView::count(const std::vector<Vec3f>& points, const SE3& T_this_points,
                     ViewAgreement& out) const {
  const Eigen::Matrix3f R = T_this_points.R.cast<float>();
  const Vec3f t = T_this_points.p.cast<float>();
  for (const Vec3f& point : points) {
    const Vec3f p = R * point + t;
    const float range_m = p.norm();
    if (!(range_m > kRangeMin_m)) continue;
    const int row = row_of(p, range_m);
    const int column = column_of(p);
    const float tolerance_m = kTolerance_m + kTolerance * range_m;
    int seen = 0;
    bool fits = false;
    float nearest_m = 0.0F;
    for (int i = std::max(0, row - 1); i <= std::min(kRows - 1, row + 1); ++i) {
      for (int j = column - 1; j <= column + 1; ++j) {
        const Cell& cell =
            cells_[static_cast<std::size_t>(i * kColumns + (j + kColumns) % kColumns)];
        if (cell.far_m <= 0.0F) continue;
        nearest_m = seen == 0 ? cell.near_m : std::min(nearest_m, cell.near_m);
        ++seen;
        fits = fits || (i == row && j == column && range_m > cell.near_m - tolerance_m &&
                        range_m < cell.far_m + tolerance_m);
      }
    }
    if (fits) ++out.agree;
    if (!fits && seen >= kSeenMin && range_m < nearest_m - tolerance_m) ++out.through;
  }
}

ViewAgreement ScanView::points_of(const ScanView& other, const SE3& T_this_other) const {
  ViewAgreement out;
  count(other.points_, T_this_other, out);
  return out;
}

ViewAgreement ScanView::compare(const ScanView& other, const SE3& T_this_other) const {
  ViewAgreement out;
  count(other.points_, T_this_other, out);
  other.count(points_, T_this_other.inverse(), out);
  return out;
}

}  // namespace rali::odometry
