#pragma once

#include <vector>

#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/point_grid.hpp"

namespace rali::odometry::paper {

/// Planar points of a cloud without rings: the normal is the direction of least spread of the
/// thinned points within 3 downsample_m. The paper's rule needs rings; this is for sensors without.
class ScatteredFeatureExtractor {
 public:
  /// @param candidates indices into `points`, thinned
  void extract(const PointsView& points, std::span<const std::uint32_t> candidates,
               const PlanarFeatureSettings& settings, PlanarFeatures& out);

 private:
  std::vector<PointNormal> thinned_;
  PointGrid grid_;
};

}  // namespace rali::odometry::paper
