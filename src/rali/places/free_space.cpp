#include "rali/places/free_space.hpp"

#include <algorithm>
#include <cmath>

namespace rali::places {

using geometry::Vec3;
using geometry::Vec3f;

/// The box around all origins, grown by the range; smaller if that has too many cells.
bool FreeSpace::lay_out(std::span<const Vec3f> origins, const FreeSpaceSettings& s) {
  nx_ = ny_ = nz_ = 0;
  state_.clear();
  if (origins.empty()) return false;
  Vec3f low = origins.front();
  Vec3f high = origins.front();
  for (const Vec3f& o : origins) {
    low = low.cwiseMin(o);
    high = high.cwiseMax(o);
  }
  double range_m = s.range_m;
  for (int attempt = 0; attempt < 20; ++attempt, range_m *= 0.7) {
    const Vec3 grow(range_m, range_m, std::min(range_m, s.height_m));
    low_ = low.cast<double>() - grow;
    const Vec3 size = ((high.cast<double>() + grow - low_) / s.cell_m).array().ceil();
    if (!(size.prod() <= static_cast<double>(s.cells_max))) continue;
    nx_ = static_cast<int>(size.x());
    ny_ = static_cast<int>(size.y());
    nz_ = static_cast<int>(size.z());
    inverse_ = 1.0 / s.cell_m;
    return true;
  }
  return false;
}

/// Marks the cells of a piece of ray, by steps of less than a cell along its longest axis.
void FreeSpace::trace(const Vec3& from, const Vec3& to, std::vector<std::uint8_t>& passed) const {
  const Vec3 a = (from - low_) * inverse_;
  const Vec3 d = (to - low_) * inverse_ - a;
  const int steps = static_cast<int>(std::ceil(d.cwiseAbs().maxCoeff()));
  if (steps <= 0) return;
  const Vec3 step = d / steps;
  Vec3 c = a + 0.5 * step;
  for (int k = 0; k < steps; ++k, c += step) {
    if (!(c.minCoeff() >= 0.0) || c.x() >= nx_ || c.y() >= ny_ || c.z() >= nz_) continue;
    std::uint8_t& count =
        passed[index(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()))];
    count = static_cast<std::uint8_t>(count + (count < 255 ? 1 : 0));
  }
}

/// Free is what was passed and has no hit in or beside it: along a wall rays run through cells
/// that the wall itself touches.
void FreeSpace::decide(const std::vector<std::uint8_t>& passed,
                       const std::vector<std::uint8_t>& hit, int rays_min) {
  state_.assign(passed.size(), Sight::kUnknown);
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (passed[i] >= rays_min) state_[i] = Sight::kFree;
  }
  for (int z = 0; z < nz_; ++z) {
    for (int y = 0; y < ny_; ++y) {
      for (int x = 0; x < nx_; ++x) {
        if (hit[index(x, y, z)] == 0) continue;
        for (int w = std::max(0, z - 1); w <= std::min(nz_ - 1, z + 1); ++w) {
          for (int v = std::max(0, y - 1); v <= std::min(ny_ - 1, y + 1); ++v) {
            for (int u = std::max(0, x - 1); u <= std::min(nx_ - 1, x + 1); ++u) {
              Sight& state = state_[index(u, v, w)];
              if (state == Sight::kFree) state = Sight::kUnknown;
            }
          }
        }
      }
    }
  }
  for (std::size_t i = 0; i < hit.size(); ++i) {
    if (hit[i] != 0) state_[i] = Sight::kHit;
  }
}

void FreeSpace::build(std::span<const Vec3f> origins, std::span<const Vec3f> points,
                      const FreeSpaceSettings& s) {
  if (!lay_out(origins, s)) return;
  const std::size_t n =
      static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * static_cast<std::size_t>(nz_);
  std::vector<std::uint8_t> passed(n, 0);
  std::vector<std::uint8_t> hit(n, 0);
  const std::size_t stride = points.size() / static_cast<std::size_t>(s.rays_max) + 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = points[i].cast<double>();
    const Vec3 c = (p - low_) * inverse_;
    if (c.minCoeff() >= 0.0 && c.x() < nx_ && c.y() < ny_ && c.z() < nz_) {
      hit[index(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()))] = 1;
    }
    if (i % stride != 0) continue;
    const Vec3 o = origins[i].cast<double>();
    const double length_m = (p - o).norm();
    const double seen_m = std::min(length_m - s.margin_m, s.range_m);
    if (seen_m > 0.0) trace(o, o + (p - o) * (seen_m / length_m), passed);
  }
  decide(passed, hit, s.rays_min);
}

}  // namespace rali::places
