#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::odometry::paper {

/// A point with its normal; zero without normal.
struct PointNormal {
  geometry::Vec3f p = geometry::Vec3f::Zero();
  geometry::Vec3f n = geometry::Vec3f::Zero();
};

/// Points sorted into cubes, for all neighbours within one fixed radius. Flat, rebuilt as a whole.
class PointGrid {
 public:
  /// Sorts `points` into cubes with the radius as edge. Points that are not finite or further than
  /// 2^20 radii from the origin are ignored.
  void build(std::span<const PointNormal> points, float radius_m);

  /// Calls f(const PointNormal&) for each point nearer than the radius, in a fixed order.
  template <class F>
  void for_each_within(const geometry::Vec3f& query, F&& f) const;

  [[nodiscard]] std::size_t size() const { return sorted_.size(); }

 private:
  struct Cell {
    std::uint64_t key = 0;  ///< 0: empty
    std::uint32_t begin = 0, end = 0;
  };

  struct Index3 {
    std::int32_t x = 0, y = 0, z = 0;
  };

  [[nodiscard]] bool index_of(const geometry::Vec3f& p, Index3& out) const;
  [[nodiscard]] static std::uint64_t key_of(const Index3& i);
  [[nodiscard]] const Cell* find(std::uint64_t key) const;
  void index_cells();

  float radius_m_ = 1.0F;
  float inverse_ = 1.0F;
  std::vector<PointNormal> sorted_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order_;
  std::vector<Cell> cells_;
  unsigned shift_ = 63;
};

template <class F>
void PointGrid::for_each_within(const geometry::Vec3f& query, F&& f) const {
  Index3 at;
  if (sorted_.empty() || !index_of(query, at)) return;
  const float radius2 = radius_m_ * radius_m_;
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dz = -1; dz <= 1; ++dz) {
        const Cell* cell = find(key_of({at.x + dx, at.y + dy, at.z + dz}));
        if (cell == nullptr) continue;
        for (std::uint32_t i = cell->begin; i < cell->end; ++i) {
          if ((sorted_[i].p - query).squaredNorm() < radius2) f(sorted_[i]);
        }
      }
    }
  }
}

}  // namespace rali::odometry::paper
