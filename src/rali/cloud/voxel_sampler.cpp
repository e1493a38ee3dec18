#include "rali/cloud/voxel_sampler.hpp"

#include <algorithm>
#include <bit>

namespace rali::cloud {

void VoxelSampler::sample(const PointSpan& points, std::span<const std::uint32_t> candidates,
                          double voxel_m, std::vector<std::uint32_t>& out) {
  const std::size_t n = candidates.empty() ? points.size : candidates.size();
  const std::size_t wanted = std::bit_ceil(std::max<std::size_t>(2 * n, 1024));
  if (slots_.size() < wanted) {
    slots_.assign(wanted, Slot{});
    generation_ = 0;
  }
  if (++generation_ == 0) {  // wrapped: old marks would look new
    std::fill(slots_.begin(), slots_.end(), Slot{});
    generation_ = 1;
  }
  const std::uint64_t mask = slots_.size() - 1;
  const float inverse = static_cast<float>(1.0 / voxel_m);
  const std::size_t first = out.size();
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = candidates.empty() ? static_cast<std::uint32_t>(k) : candidates[k];
    const float fx = points.x_m[i] * inverse;
    const float fy = points.y_m[i] * inverse;
    const float fz = points.z_m[i] * inverse;
    const int ix = floor_to_int(fx);
    const int iy = floor_to_int(fy);
    const int iz = floor_to_int(fz);
    const float dx = fx - static_cast<float>(ix) - 0.5F;
    const float dy = fy - static_cast<float>(iy) - 0.5F;
    const float dz = fz - static_cast<float>(iz) - 0.5F;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    const std::uint64_t key = voxel_key(ix, iy, iz);
    std::uint64_t s = hash_key(key) & mask;
    while (slots_[s].generation == generation_ && slots_[s].key != key) s = (s + 1) & mask;
    Slot& slot = slots_[s];
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

}  // namespace rali::cloud
