#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry::paper {

/// Points in flat arrays, all of the same length, in the LiDAR frame [m].
struct PointsView {
  std::span<const float> x_m, y_m, z_m;
  std::span<const std::uint16_t> ring;  ///< index of the laser, ordered by elevation

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

[[nodiscard]] inline PointsView view_of(const sensor::LidarScan& scan) {
  return {scan.x_m, scan.y_m, scan.z_m, scan.ring};
}

struct PlanarFeatureSettings {
  double downsample_m = 0.2;
  double theta_planar_deg = 10.0;
};

/// Planar points with their normals, in the frame of the input.
struct PlanarFeatures {
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> nx, ny, nz;     ///< unit, oriented towards the sensor: n . p < 0
  std::vector<std::uint8_t> turned;  ///< 1 if the cross products pointed away from the sensor

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  void clear();
};

/// Extracts planar points by the rule of the ring neighbours. Reuses its memory between scans.
///
/// The cloud is thinned to one measured point per cube of downsample_m. A thinned point is planar
/// under two conditions. It has a neighbour on each side on its own ring, one on a ring above and
/// one on a ring below (the nearest rings with one), all within 2 downsample_m. The normals n_G,
/// n_O of the upper and the lower half agree within theta_planar_deg. Points of the highest and the
/// lowest ring are never planar.
/// Source: paper, section "Feature Extraction"; algorithms.md 2.1.
class PlanarFeatureExtractor {
 public:
  /// Points that are not finite or further than 2^19 downsample_m away are ignored.
  void extract(const PointsView& points, const PlanarFeatureSettings& settings,
               PlanarFeatures& out);

  /// Indices of the thinned points of the last call, sorted by ring and azimuth.
  [[nodiscard]] std::span<const std::uint32_t> thinned() const { return kept_; }

 private:
  /// A thinned point in the order of ring and azimuth.
  struct Node {
    float x_m, y_m, z_m;
    float azimuth;  ///< pseudo angle in [0, 4), grows with the azimuth
  };

  struct Link {
    const Node* node = nullptr;
    float distance2 = 0.0F;
  };

  std::size_t sort_by_ring(const PointsView& points);
  bool add_cell(std::uint64_t key);
  void grow_cells();
  void thin(const PointsView& points, float cell_m);
  void order_rings(const PointsView& points);
  [[nodiscard]] Link nearest_on_ring(std::size_t ring, const Node& at) const;
  [[nodiscard]] const Node* nearest_ring_neighbour(std::size_t ring, int step, const Node& at,
                                                   float radius2) const;
  void test_candidate(std::size_t ring, std::size_t index, float radius2, float cos_theta,
                      PlanarFeatures& out) const;

  std::vector<std::uint32_t> by_ring_;  // all points, ring by ring
  std::vector<std::uint32_t> ring_cursor_;
  std::vector<std::uint64_t> cells_;       // open addressing, at most half full: occupied cubes
  std::vector<std::uint32_t> kept_;        // thinned points, sorted by ring and azimuth
  std::vector<Node> nodes_;                // parallel to kept_
  std::vector<std::uint32_t> ring_begin_;  // into nodes_, one more than rings
  std::vector<std::uint32_t> bin_begin_;   // into nodes_, per ring and azimuth bin
  std::vector<std::pair<float, std::uint32_t>> order_;
};

/// The same without an extractor to reuse.
void extract_planar_features(const sensor::LidarScan& scan, const PlanarFeatureSettings& settings,
                             PlanarFeatures& out);

}  // namespace rali::odometry::paper
