#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "rali/base/finding.hpp"
#include "rali/map/block_vector.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/map/map_cloud.hpp"
#include "rali/map/settings.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

/// Merges keyframes into one point per voxel: mean position, mean intensity, expected error, number
/// of keyframes that saw it.
///
/// Expected error: errors common to keyframes do not average out. The pose errors of neighbouring
/// keyframes are almost the same error, so the mean of k points carries the mean of their pose
/// sigmas (the bound for full correlation, Cauchy-Schwarz), while range and bearing noise are
/// independent and shrink with 1/k:
///   sigma^2 = (mean of sqrt(pose_i^2 + systematic^2))^2 + sum(noise_i^2) / k^2.
class MapBuilder {
 public:
  explicit MapBuilder(const MapSettings& settings);

  /// Adds the points of one keyframe. One that fails is_usable() is left out and counted.
  void add(const KeyframeView& keyframe);

  struct Parts {
    MapCloud map;
    MapCloud removed;
  };

  /// The map, sorted by voxel (x, y, z); in order of arrival if every point is kept. Points for
  /// which `is_removed(p_map)` holds go to the second part; an empty function removes nothing.
  [[nodiscard]] Parts finish(const std::function<bool(const geometry::Vec3&)>& is_removed,
                             FindingList& findings) const;

  [[nodiscard]] std::size_t size() const { return cells_.size(); }

  [[nodiscard]] std::size_t memory_bytes() const {
    return index_.memory_bytes() + cells_.memory_bytes();
  }

 private:
  /// Means of the points in one voxel. Positions are offsets from the voxel's corner, where a float
  /// is exact to nanometres however large the map is.
  struct Cell {
    VoxelKey key = kNoVoxel;
    float x_m = 0.0F, y_m = 0.0F, z_m = 0.0F;
    float intensity = 0.0F;
    float sigma_shared_m = 0.0F;
    float noise_sum_m2 = 0.0F;
    std::uint32_t count = 0;
    std::uint32_t last_keyframe = 0;
    std::uint16_t seen = 0;
    std::uint8_t vehicle = 0;
  };

  struct Sample {
    VoxelKey key;
    geometry::Vec3 p_map_m;
    float intensity, sigma_shared_m, noise_m2;
  };

  void add_sample(const Sample& sample, std::uint8_t vehicle);
  [[nodiscard]] Cell* cell_for(VoxelKey key);
  [[nodiscard]] bool has_room() const;
  [[nodiscard]] geometry::Vec3 position(const Cell& cell) const;
  [[nodiscard]] geometry::Vec3 common_origin() const;
  static void append(const Cell& cell, const geometry::Vec3& p_map_m, MapCloud& out);
  void report(FindingList& findings) const;

  MapSettings settings_;
  double lattice_m_;  ///< voxel side, or 1 m where every point is kept
  VoxelIndex index_;
  BlockVector<Cell> cells_;
  std::uint32_t keyframes_ = 0;
  std::uint64_t keyframes_refused_ = 0;
  std::uint64_t points_refused_ = 0;  ///< not a number, or too far away
  std::uint64_t points_no_room_ = 0;
};

}  // namespace rali::map
