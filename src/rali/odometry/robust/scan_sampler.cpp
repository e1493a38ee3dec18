#include "rali/odometry/robust/scan_sampler.hpp"

#include <algorithm>

namespace rali::odometry {

void thin_evenly(std::vector<std::uint32_t>& indices, std::size_t n_max) {
  if (indices.size() <= n_max) return;
  const double share = static_cast<double>(n_max) / static_cast<double>(indices.size());
  const auto limit = static_cast<std::uint64_t>(share * 0x1.0p63);
  std::erase_if(indices, [limit](std::uint32_t i) {
    return (cloud::hash_key(i + 0x9e3779b97f4a7c15ULL) >> 1) >= limit;
  });
}

void ScanSampler::sample(const sensor::LidarScan& scan) {
  update_.clear();
  insert_.clear();
  if (scan.size() == 0) return;
  const cloud::PointSpan points{scan.x_m.data(), scan.y_m.data(), scan.z_m.data(), scan.size()};
  sampler_.sample(points, {}, settings_.insert_voxel_m, insert_);
  sampler_.sample(points, insert_, settings_.update_voxel_m, update_);
  thin_evenly(insert_, static_cast<std::size_t>(settings_.insert_points_max));
  thin_evenly(update_, static_cast<std::size_t>(settings_.update_points_max));
}

}  // namespace rali::odometry
