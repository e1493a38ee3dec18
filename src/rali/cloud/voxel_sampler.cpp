#include "rali/cloud/voxel_sampler.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rali::cloud {

namespace {

/// Cells of a block of points, in flat arrays that the compiler can vectorise by four.
struct Block {
  static constexpr std::size_t kSize = 64;
  float x[kSize], y[kSize], z[kSize];
  int ix[kSize], iy[kSize], iz[kSize];
  float distance2[kSize];
  std::uint64_t key[kSize];
};

/// Computes cells and distances from the coordinates; always kSize points.
template <class Scale>
void locate(Block& b, Scale scale) {
  for (std::size_t k = 0; k < Block::kSize; ++k) {
    const float s = scale(b.x[k], b.y[k], b.z[k]);
    const float fx = b.x[k] * s;
    const float fy = b.y[k] * s;
    const float fz = b.z[k] * s;
    b.ix[k] = floor_to_int(fx);
    b.iy[k] = floor_to_int(fy);
    b.iz[k] = floor_to_int(fz);
    const float dx = fx - static_cast<float>(b.ix[k]) - 0.5F;
    const float dy = fy - static_cast<float>(b.iy[k]) - 0.5F;
    const float dz = fz - static_cast<float>(b.iz[k]) - 0.5F;
    b.distance2[k] = dx * dx + dy * dy + dz * dz;
  }
}

void load(const PointSpan& points, std::size_t first, std::size_t n, Block& b) {
  std::copy_n(points.x_m + first, n, b.x);
  std::copy_n(points.y_m + first, n, b.y);
  std::copy_n(points.z_m + first, n, b.z);
}

void load(const PointSpan& points, const std::uint32_t* indices, std::size_t n, Block& b) {
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = indices[k];
    b.x[k] = points.x_m[i];
    b.y[k] = points.y_m[i];
    b.z[k] = points.z_m[i];
  }
}

}  // namespace

void VoxelSampler::prepare(std::size_t n) {
  // At least four points per cell are expected; a larger table would not fit the cache.
  slots_.assign(std::bit_ceil(std::max<std::size_t>(n / 2, 1024)), Slot{kFree, 0, 0.0F});
  used_.clear();
}

void VoxelSampler::grow() {
  old_slots_.swap(slots_);
  slots_.assign(2 * old_slots_.size(), Slot{kFree, 0, 0.0F});
  const std::uint64_t mask = slots_.size() - 1;
  for (std::uint32_t& at : used_) {
    const Slot& slot = old_slots_[at];
    std::uint64_t s = hash_key(slot.key) & mask;
    while (slots_[s].key != kFree) s = (s + 1) & mask;
    slots_[s] = slot;
    at = static_cast<std::uint32_t>(s);
  }
}

inline void VoxelSampler::offer(std::uint64_t key, float distance2, std::uint32_t point) {
  const std::uint64_t mask = slots_.size() - 1;
  std::uint64_t at = hash_key(key) & mask;
  while (slots_[at].key != key) {
    if (slots_[at].key == kFree) {
      slots_[at] = {key, point, distance2};
      used_.push_back(static_cast<std::uint32_t>(at));
      if (2 * used_.size() > slots_.size()) grow();
      return;
    }
    at = (at + 1) & mask;
  }
  // Branch-free: which point is nearer cannot be predicted.
  Slot& slot = slots_[at];
  const bool nearer = distance2 < slot.distance2;
  slot.distance2 = nearer ? distance2 : slot.distance2;
  slot.point = nearer ? point : slot.point;
}

/// Ascending without sorting: one bit per point.
void VoxelSampler::collect(std::size_t n_points, std::vector<std::uint32_t>& out) {
  chosen_.assign((n_points + 63) / 64, 0);
  for (const std::uint32_t at : used_) {
    const std::uint32_t point = slots_[at].point;
    chosen_[point / 64] |= std::uint64_t{1} << (point % 64);
  }
  out.reserve(out.size() + used_.size());
  for (std::size_t word = 0; word < chosen_.size(); ++word) {
    for (std::uint64_t bits = chosen_[word]; bits != 0; bits &= bits - 1) {
      out.push_back(static_cast<std::uint32_t>(64 * word) +
                    static_cast<std::uint32_t>(std::countr_zero(bits)));
    }
  }
}

/// @param scale (x, y, z) -> factor from metres to cells.
template <class Scale>
void VoxelSampler::run(const PointSpan& points, std::span<const std::uint32_t> candidates,
                       Scale scale, std::vector<std::uint32_t>& out) {
  const bool all = candidates.empty();
  const std::size_t n = all ? points.size : candidates.size();
  prepare(n);
  Block b{};
  for (std::size_t first = 0; first < n; first += Block::kSize) {
    const std::size_t size = std::min(Block::kSize, n - first);
    if (all) {
      load(points, first, size, b);
    } else {
      load(points, candidates.data() + first, size, b);
    }
    locate(b, scale);
    // Prefetches all slots of the block before the first is used.
    const std::uint64_t mask = slots_.size() - 1;
    for (std::size_t k = 0; k < Block::kSize; ++k) {
      b.key[k] = voxel_key(b.ix[k], b.iy[k], b.iz[k]);
      __builtin_prefetch(&slots_[hash_key(b.key[k]) & mask]);
    }
    for (std::size_t k = 0; k < size; ++k) {
      const auto i = all ? static_cast<std::uint32_t>(first + k) : candidates[first + k];
      offer(b.key[k], b.distance2[k], i);
    }
  }
  collect(points.size, out);
}

void VoxelSampler::sample(const PointSpan& points, std::span<const std::uint32_t> candidates,
                          double voxel_m, std::vector<std::uint32_t>& out) {
  const float inverse = static_cast<float>(1.0 / voxel_m);
  run(
      points, candidates, [inverse](float, float, float) { return inverse; }, out);
}

void VoxelSampler::sample_rays(const PointSpan& points, std::span<const std::uint32_t> candidates,
                               double spacing_m, std::vector<std::uint32_t>& out) {
  const float inverse = static_cast<float>(1.0 / spacing_m);
  // Each point is moved along its ray to a sphere whose radius is its range rounded down to a
  // power of sqrt(2): range^2 = m 2^e with 1 <= m < 2, radius^2 = 2^e, factor 1/sqrt(m).
  const auto scale = [inverse](float x, float y, float z) {
    constexpr std::uint32_t kMantissa = 0x007fffffU;
    constexpr std::uint32_t kOne = 0x3f800000U;
    const float range2 = x * x + y * y + z * z;
    const float m = std::bit_cast<float>((std::bit_cast<std::uint32_t>(range2) & kMantissa) | kOne);
    return inverse / std::sqrt(m);
  };
  run(points, candidates, scale, out);
}

}  // namespace rali::cloud
