#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::map {

/// A cube of a lattice: 21 bits per axis, ordered by x, then y, then z.
using VoxelKey = std::uint64_t;

inline constexpr VoxelKey kNoVoxel = ~VoxelKey{0};
inline constexpr std::int64_t kVoxelHalfRange = std::int64_t{1} << 20;

/// Key of the cube with integer coordinates; kNoVoxel beyond +-2^20 cubes.
[[nodiscard]] inline VoxelKey voxel_key(std::int64_t ix, std::int64_t iy, std::int64_t iz) {
  const auto inside = [](std::int64_t i) { return i >= -kVoxelHalfRange && i < kVoxelHalfRange; };
  if (!inside(ix) || !inside(iy) || !inside(iz)) return kNoVoxel;
  const auto bits = [](std::int64_t i) { return static_cast<VoxelKey>(i + kVoxelHalfRange); };
  return bits(ix) << 42 | bits(iy) << 21 | bits(iz);
}

/// Key of the cube of side `side_m` that holds p; kNoVoxel if p is not a number or too far away
/// (52 km at 0.05 m).
[[nodiscard]] inline VoxelKey voxel_key(const geometry::Vec3& p_m, double side_m) {
  const geometry::Vec3 q = p_m / side_m;
  if (!(q.cwiseAbs().maxCoeff() < static_cast<double>(kVoxelHalfRange))) return kNoVoxel;
  const auto whole = [](double v) { return static_cast<std::int64_t>(std::floor(v)); };
  return voxel_key(whole(q.x()), whole(q.y()), whole(q.z()));
}

/// The corner of the cube with the smallest coordinates.
[[nodiscard]] inline geometry::Vec3 voxel_corner(VoxelKey key, double side_m) {
  constexpr VoxelKey kMask = (VoxelKey{1} << 21) - 1;
  const auto whole = [](VoxelKey bits) {
    return static_cast<double>(static_cast<std::int64_t>(bits & kMask) - kVoxelHalfRange);
  };
  return geometry::Vec3{whole(key >> 42), whole(key >> 21), whole(key)} * side_m;
}

/// Numbers keys 0, 1, 2, ... in order of first insertion: open addressing, linear probing, so that
/// data per cube lies flat in the caller's own arrays and never in hash order.
class VoxelIndex {
 public:
  VoxelIndex();

  struct Slot {
    std::uint32_t index = 0;
    bool is_new = false;
  };

  /// The key's number, a new one for a new key.
  [[nodiscard]] Slot insert(VoxelKey key);
  [[nodiscard]] std::optional<std::uint32_t> find(VoxelKey key) const;

  [[nodiscard]] std::size_t size() const { return size_; }

  [[nodiscard]] std::size_t memory_bytes() const;
  /// Memory during the next insert, if it has to grow the table.
  [[nodiscard]] std::size_t memory_bytes_at_next_insert() const;

 private:
  [[nodiscard]] std::size_t slot_of(VoxelKey key) const;

  [[nodiscard]] bool is_full() const { return (size_ + 1) * 10 > keys_.size() * 7; }

  void grow();

  std::vector<VoxelKey> keys_;
  std::vector<std::uint32_t> indices_;
  std::size_t size_ = 0;
};

}  // namespace rali::map
