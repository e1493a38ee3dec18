#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/geometry/types.hpp"

namespace rali::places {

/// Radius search over points sorted by the cubes they are in. Its results and their order depend on
/// the points alone.
class GridIndex {
 public:
  void build(std::span<const geometry::Vec3> points, double cell_m);

  [[nodiscard]] bool empty() const { return items_.empty(); }

  /// Calls f(index) for all points in the cubes that touch the cube of side 2 radius_m around p: a
  /// superset of the points within the radius.
  template <class F>
  void near(const geometry::Vec3& p, double radius_m, F f) const {
    if (items_.empty()) return;
    const Cell lo = cell_of(p.array() - radius_m);
    const Cell hi = cell_of(p.array() + radius_m);
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          const Slot* slot = find(cloud::voxel_key(x, y, z));
          if (slot == nullptr) continue;
          for (std::uint32_t k = slot->begin; k < slot->end; ++k) f(items_[k]);
        }
      }
    }
  }

 private:
  struct Cell {
    int x, y, z;
  };

  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t begin = 0, end = 0;  ///< end 0: free
  };

  [[nodiscard]] Cell cell_of(const geometry::Vec3& p) const {
    return {cloud::floor_to_int(p.x() * inverse_), cloud::floor_to_int(p.y() * inverse_),
            cloud::floor_to_int(p.z() * inverse_)};
  }

  [[nodiscard]] const Slot* find(std::uint64_t key) const {
    const std::uint64_t mask = slots_.size() - 1;
    for (std::uint64_t s = cloud::hash_key(key) & mask; slots_[s].end != 0; s = (s + 1) & mask) {
      if (slots_[s].key == key) return &slots_[s];
    }
    return nullptr;
  }

  double inverse_ = 1.0;
  std::vector<std::uint32_t> items_;
  std::vector<Slot> slots_;  ///< open addressing, at most half full
};

}  // namespace rali::places
