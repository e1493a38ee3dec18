#include "rali/places/free_space.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::places {

using geometry::Vec3;
using geometry::Vec3f;

namespace {

void raise(std::uint8_t& count) {
  count = static_cast<std::uint8_t>(count + (count < 255 ? 1 : 0));
}

}  // namespace

/// The bounding box of all origins, grown by the range; the range shrinks if the box has too many
/// cells.
bool FreeSpace::lay_out(std::span<const Look> looks, const FreeSpaceSettings& s) {
  nx_ = ny_ = nz_ = 0;
  first_.setZero();
  packed_.clear();
  if (looks.empty()) return false;
  Vec3f low = looks.front().origin;
  Vec3f high = looks.front().origin;
  for (const Look& look : looks) {
    low = low.cwiseMin(look.origin);
    high = high.cwiseMax(look.origin);
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

/// Marks the cell and its neighbours: rays along a wall pass through cells that the wall touches.
void FreeSpace::mark_near(const Vec3& p, std::uint16_t scan, Counts& counts) const {
  if (!cell_of(p)) return;
  const Vec3 c = (p - low_) * inverse_;
  const int x = static_cast<int>(c.x()), y = static_cast<int>(c.y()), z = static_cast<int>(c.z());
  const int x_begin = std::max(0, x - 1), x_end = std::min(nx_, x + 2);
  for (int w = std::max(0, z - 1); w < std::min(nz_, z + 2); ++w) {
    for (int v = std::max(0, y - 1); v < std::min(ny_, y + 2); ++v) {
      const auto row = counts.near.begin() + static_cast<std::ptrdiff_t>(index(0, v, w));
      std::fill(row + x_begin, row + x_end, scan);
    }
  }
}

/// Counts the cells along a part of a ray, in steps of less than a cell along its longest axis.
void FreeSpace::trace(const Vec3& from, const Vec3& to, std::uint16_t scan, Counts& counts) const {
  const Vec3 a = (from - low_) * inverse_;
  const Vec3 d = (to - low_) * inverse_ - a;
  const int steps = static_cast<int>(std::ceil(d.cwiseAbs().maxCoeff()));
  if (steps <= 0) return;
  const Vec3 step = d / steps;
  Vec3 c = a + 0.5 * step;
  for (int k = 0; k < steps; ++k, c += step) {
    if (!(c.minCoeff() >= 0.0) || c.x() >= nx_ || c.y() >= ny_ || c.z() >= nz_) continue;
    const std::size_t i =
        index(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()));
    raise(counts.passed[i]);
    if (counts.hit[i] == 0 || counts.near[i] == scan || counts.last[i] == scan) continue;
    counts.last[i] = scan;
    raise(counts.through[i]);
  }
}

std::vector<Sight> FreeSpace::decided(const Counts& counts, int rays_min) {
  std::vector<Sight> state(counts.hit.size(), Sight::kUnknown);
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (counts.hit[i] != 0) {
      state[i] = counts.through[i] >= rays_min ? Sight::kLoose : Sight::kHit;
    } else if (counts.passed[i] >= rays_min && counts.near[i] == 0) {
      state[i] = Sight::kFree;
    }
  }
  return state;
}

/// Crops the grid to its known cells and packs them: indoors, most of the box is never seen, and a
/// long mission keeps hundreds of such grids.
void FreeSpace::keep_known(const std::vector<Sight>& state) {
  Eigen::Vector3i low(nx_, ny_, nz_), high(0, 0, 0);
  for (int z = 0; z < nz_; ++z) {
    for (int y = 0; y < ny_; ++y) {
      for (int x = 0; x < nx_; ++x) {
        if (state[index(x, y, z)] == Sight::kUnknown) continue;
        low = low.cwiseMin(Eigen::Vector3i(x, y, z));
        high = high.cwiseMax(Eigen::Vector3i(x + 1, y + 1, z + 1));
      }
    }
  }
  const Eigen::Vector3i size = (high - low).cwiseMax(0);
  packed_.assign((static_cast<std::size_t>(size.prod()) + 3) / 4, 0);
  std::size_t at = 0;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      const std::size_t row = index(low.x(), low.y() + y, low.z() + z);
      for (int x = 0; x < size.x(); ++x, ++at) {
        const auto sight = static_cast<unsigned>(state[row + static_cast<std::size_t>(x)]);
        packed_[at / 4] = static_cast<std::uint8_t>(packed_[at / 4] | sight << 2 * (at % 4));
      }
    }
  }
  first_ = low.cast<double>();
  nx_ = size.x();
  ny_ = size.y();
  nz_ = size.z();
}

void FreeSpace::build(std::span<const Look> looks, const FreeSpaceSettings& s) {
  if (!lay_out(looks, s)) return;
  const std::size_t n =
      static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * static_cast<std::size_t>(nz_);
  Counts counts;
  counts.passed.assign(n, 0);
  counts.hit.assign(n, 0);
  counts.through.assign(n, 0);
  counts.near.assign(n, 0);
  counts.last.assign(n, 0);
  std::size_t points = 0;
  for (const Look& look : looks) {
    points += look.points.size();
    for (const Vec3f& p : look.points) {
      if (const auto cell = cell_of(p.cast<double>())) counts.hit[*cell] = 1;
    }
  }
  const std::size_t stride = points / static_cast<std::size_t>(s.rays_max) + 1;
  std::size_t number = 0;
  for (std::size_t k = 0; k < looks.size(); ++k) {
    const auto scan = static_cast<std::uint16_t>(k % 65535 + 1);
    for (const Vec3f& p : looks[k].points) mark_near(p.cast<double>(), scan, counts);
    const Vec3 o = looks[k].origin.cast<double>();
    for (const Vec3f& point : looks[k].points) {
      if (number++ % stride != 0) continue;
      const Vec3 p = point.cast<double>();
      const double length_m = (p - o).norm();
      const double seen_m = std::min(length_m - s.margin_m, s.range_m);
      if (seen_m > 0.0) trace(o, o + (p - o) * (seen_m / length_m), scan, counts);
    }
  }
  keep_known(decided(counts, s.rays_min));
}

}  // namespace rali::places
