#include "rali/places/density.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace rali::places {

using geometry::Vec2;

namespace {

constexpr float kEnough = 4.0F;   // points in a cell that give it full weight
constexpr float kLateral = 0.6F;  // weight of a mark in the cells beside it
constexpr float kAcross = 0.4F;   // and in the diagonal ones

}  // namespace

std::vector<Mark> marks_of(const Submap& submap, double cell_m, const BandSettings& band) {
  const double low_z = submap.ground_z_m() + band.low_m;
  const double high_z = submap.ground_z_m() + band.high_m;
  const int half = static_cast<int>(std::ceil(band.range_m / cell_m));
  const std::size_t side = static_cast<std::size_t>(2 * half);
  std::vector<float> counts(side * side, 0.0F);
  for (std::size_t i = 0; i < submap.points(); ++i) {
    const geometry::Vec3f p = submap.point_m(i);
    const double z = static_cast<double>(p.z());
    if (z < low_z || z > high_z) continue;
    const double x = static_cast<double>(p.x()) / cell_m + half;
    const double y = static_cast<double>(p.y()) / cell_m + half;
    if (!(x >= 0.0) || !(y >= 0.0) || x >= 2 * half || y >= 2 * half) continue;
    counts[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)] += 1.0F;
  }
  std::vector<Mark> marks;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] <= 0.0F) continue;
    const double x = (static_cast<double>(i % side) - half + 0.5) * cell_m;
    const double y = (static_cast<double>(i / side) - half + 0.5) * cell_m;
    marks.push_back(
        {static_cast<float>(x), static_cast<float>(y), std::min(1.0F, counts[i] / kEnough)});
  }
  return marks;
}

Picture::Picture(std::span<const Mark> marks, double cell_m) : inverse_(1.0 / cell_m) {
  if (marks.empty()) return;
  Vec2 low(marks[0].x_m, marks[0].y_m);
  Vec2 high = low;
  for (const Mark& m : marks) {
    low = low.cwiseMin(Vec2(m.x_m, m.y_m));
    high = high.cwiseMax(Vec2(m.x_m, m.y_m));
  }
  low_ = low.array() - 1.5 * cell_m;
  nx_ = static_cast<int>(std::lround((high.x() - low.x()) * inverse_)) + 3;
  ny_ = static_cast<int>(std::lround((high.y() - low.y()) * inverse_)) + 3;
  cells_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_), 0.0F);
  for (const Mark& m : marks) {
    const int x = static_cast<int>((static_cast<double>(m.x_m) - low_.x()) * inverse_);
    const int y = static_cast<int>((static_cast<double>(m.y_m) - low_.y()) * inverse_);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const float fraction =
            dx == 0 && dy == 0 ? 1.0F : (dx == 0 || dy == 0 ? kLateral : kAcross);
        float& cell = cells_[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(nx_) +
                             static_cast<std::size_t>(x + dx)];
        cell = std::max(cell, fraction * m.weight);
      }
    }
  }
}

double correlation(const Picture& picture, std::span<const Mark> marks, double yaw_rad,
                   const Vec2& shift_m) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  double on = 0.0;
  double all = 0.0;
  for (const Mark& m : marks) {
    const double x = static_cast<double>(m.x_m);
    const double y = static_cast<double>(m.y_m);
    const double w = static_cast<double>(m.weight);
    on += w *
          static_cast<double>(picture.at(c * x - s * y + shift_m.x(), s * x + c * y + shift_m.y()));
    all += w;
  }
  return all > 0.0 ? on / all : 0.0;
}

}  // namespace rali::places
