#include "rali/cloud/voxel_sampler.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rali::cloud {

void VoxelSampler::prepare(std::size_t n) {
  const std::size_t wanted = std::bit_ceil(std::max<std::size_t>(2 * n, 1024));
  if (slots_.size() < wanted) {
    slots_.assign(wanted, Slot{});
    generation_ = 0;
  }
  if (++generation_ == 0) {  // wrapped: old marks would look new
    std::fill(slots_.begin(), slots_.end(), Slot{});
    generation_ = 1;
  }
}

/// @param scale (x, y, z) -> factor from metres to cells.
template <class Scale>
void VoxelSampler::run(const PointSpan& points, std::span<const std::uint32_t> candidates,
                       Scale scale, std::vector<std::uint32_t>& out) {
  const std::size_t n = candidates.empty() ? points.size : candidates.size();
  prepare(n);
  const std::uint64_t mask = slots_.size() - 1;
  const std::size_t first = out.size();
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = candidates.empty() ? static_cast<std::uint32_t>(k) : candidates[k];
    const float s = scale(points.x_m[i], points.y_m[i], points.z_m[i]);
    const float fx = points.x_m[i] * s;
    const float fy = points.y_m[i] * s;
    const float fz = points.z_m[i] * s;
    const int ix = floor_to_int(fx);
    const int iy = floor_to_int(fy);
    const int iz = floor_to_int(fz);
    const float dx = fx - static_cast<float>(ix) - 0.5F;
    const float dy = fy - static_cast<float>(iy) - 0.5F;
    const float dz = fz - static_cast<float>(iz) - 0.5F;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    const std::uint64_t key = voxel_key(ix, iy, iz);
    std::uint64_t at = hash_key(key) & mask;
    while (slots_[at].generation == generation_ && slots_[at].key != key) at = (at + 1) & mask;
    Slot& slot = slots_[at];
    if (slot.generation != generation_) {
      slot = {key, generation_, static_cast<std::uint32_t>(out.size()), distance2};
      out.push_back(i);
    } else if (distance2 < slot.distance2) {
      slot.distance2 = distance2;
      out[slot.index] = i;
    }
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
}

void VoxelSampler::sample(const PointSpan& points, std::span<const std::uint32_t> candidates,
                          double voxel_m, std::vector<std::uint32_t>& out) {
  const float inverse = static_cast<float>(1.0 / voxel_m);
  run(points, candidates, [inverse](float, float, float) { return inverse; }, out);
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
