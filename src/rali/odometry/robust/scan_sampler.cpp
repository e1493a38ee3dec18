#include "rali/odometry/robust/scan_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace rali::odometry {

void thin_evenly(std::vector<std::uint32_t>& indices, std::size_t n_max) {
  if (indices.size() <= n_max) return;
  const double fraction = static_cast<double>(n_max) / static_cast<double>(indices.size());
  const auto limit = static_cast<std::uint64_t>(fraction * 0x1.0p63);
  std::erase_if(indices, [limit](std::uint32_t i) {
    return (cloud::hash_key(i + 0x9e3779b97f4a7c15ULL) >> 1) >= limit;
  });
}

ScanSampler::ScanSampler(const SamplingSettings& settings)
    : settings_(settings),
      insert_spacing_{0.1, settings.insert_points},
      update_spacing_{0.3, settings.update_points} {}

void ScanSampler::sample_one(const cloud::PointSpan& points,
                             const std::vector<std::uint32_t>& candidates, Spacing& spacing,
                             std::vector<std::uint32_t>& out) {
  // Twice if the first choice is far off the wanted number, e.g. through a door into a hall.
  for (int round = 0; round < 2; ++round) {
    out.clear();
    sampler_.sample_rays(points, candidates, spacing.spacing_m, out);
    const double ratio = static_cast<double>(out.size()) / spacing.wanted;
    const bool poor = ratio > 2.0 || ratio < 0.5;
    // The number varies with the square of the spacing; rings leave gaps, so half the step.
    spacing.spacing_m = std::clamp(spacing.spacing_m * std::sqrt(std::sqrt(ratio)) *
                                       (poor ? std::sqrt(std::sqrt(ratio)) : 1.0),
                                   settings_.spacing_min_m, settings_.spacing_max_m);
    if (!poor) break;
  }
  thin_evenly(out, static_cast<std::size_t>(2 * spacing.wanted));
}

void ScanSampler::sample(const sensor::LidarScan& scan) {
  update_.clear();
  insert_.clear();
  if (scan.size() == 0) return;
  const cloud::PointSpan points{scan.x_m.data(), scan.y_m.data(), scan.z_m.data(), scan.size()};
  sample_one(points, {}, insert_spacing_, insert_);
  sample_one(points, insert_, update_spacing_, update_);
}

}  // namespace rali::odometry
