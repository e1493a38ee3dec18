#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::eval {

using PointList = std::vector<geometry::Vec3>;

/// Keeps one point per cube of cell_m, so that walls near the vehicle, which it measured most
/// often, do not dominate. The choice is independent of the point's error: it is a pseudo-random
/// draw by the index in the list, the same each time. Points that are not finite are left out.
/// Result in the order of the list.
[[nodiscard]] PointList thinned(const PointList& points, double cell_m);

/// At most n points, drawn in the same way as by thinned().
[[nodiscard]] PointList drawn(const PointList& points, std::size_t n);

/// Finds points within a radius: indices sorted by cubes of that size. Flat memory; queries are
/// thread-safe.
class PointGrid {
 public:
  /// @param points finite; must outlive the grid
  PointGrid(const PointList& points, double radius_m);

  /// Calls f(index, squared distance) for each point within radius_m of p, always in the same
  /// order; f returns false to stop.
  template <class F>
  void for_each_near(const geometry::Vec3& p, const F& f) const;

 private:
  struct Cell {
    std::uint64_t key;
    std::uint32_t begin;
  };

  [[nodiscard]] std::uint64_t coordinate(double value, int axis) const;

  [[nodiscard]] static std::uint64_t key(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
    return (x << 42) | (y << 21) | z;
  }

  [[nodiscard]] std::size_t first_cell(std::uint64_t key) const;

  static constexpr std::uint64_t kLast = (std::uint64_t{1} << 21) - 1;

  const PointList& points_;
  double radius_m_;
  geometry::Vec3 low_;
  std::vector<Cell> cells_;           ///< increasing keys, and one past the last
  std::vector<std::uint32_t> order_;  ///< indices of points, cell after cell
};

template <class F>
void PointGrid::for_each_near(const geometry::Vec3& p, const F& f) const {
  if (order_.empty()) return;
  const double radius2 = radius_m_ * radius_m_;
  const geometry::Vec3 a = p.array() - radius_m_;
  const geometry::Vec3 b = p.array() + radius_m_;
  for (std::uint64_t x = coordinate(a.x(), 0); x <= coordinate(b.x(), 0); ++x) {
    for (std::uint64_t y = coordinate(a.y(), 1); y <= coordinate(b.y(), 1); ++y) {
      const std::uint64_t last = key(x, y, coordinate(b.z(), 2));
      for (std::size_t c = first_cell(key(x, y, coordinate(a.z(), 2))); cells_[c].key <= last;
           ++c) {
        for (std::uint32_t i = cells_[c].begin; i < cells_[c + 1].begin; ++i) {
          const double d2 = (points_[order_[i]] - p).squaredNorm();
          if (d2 <= radius2 && !f(order_[i], d2)) return;
        }
      }
    }
  }
}

}  // namespace rali::eval
