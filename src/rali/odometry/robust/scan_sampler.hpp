#pragma once

#include <cstdint>
#include <vector>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// Chooses the points of a scan for the update and those for the map. Works on the measured points,
/// so that the choice per voxel does not depend on the exact motion.
class ScanSampler {
 public:
  explicit ScanSampler(const SamplingSettings& settings);

  void sample(const sensor::LidarScan& scan);

  [[nodiscard]] const std::vector<std::uint32_t>& update_indices() const { return update_; }

  [[nodiscard]] const std::vector<std::uint32_t>& insert_indices() const { return insert_; }

 private:
  /// Adapts the spacing from scan to scan to get the wanted number of points.
  struct Spacing {
    double spacing_m = 0.1;
    int wanted = 0;
  };

  void sample_one(const cloud::PointSpan& points, const std::vector<std::uint32_t>& candidates,
                  Spacing& spacing, std::vector<std::uint32_t>& out);

  SamplingSettings settings_;
  Spacing insert_spacing_, update_spacing_;
  cloud::VoxelSampler sampler_;
  std::vector<std::uint32_t> update_, insert_;
};

/// Keeps about n_max of the indices, chosen by a hash of each: a stride would favour rings.
void thin_evenly(std::vector<std::uint32_t>& indices, std::size_t n_max);

}  // namespace rali::odometry
