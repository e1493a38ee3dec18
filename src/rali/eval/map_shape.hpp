#pragma once

#include <optional>
#include <span>

#include "rali/base/executor.hpp"
#include "rali/eval/point_grid.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::eval {

/// Spread of a set of points about its mean.
struct PatchShape {
  double thickness_m = 0.0;  ///< sqrt of the smallest eigenvalue of the covariance
  double flatness = 0.0;     ///< smallest eigenvalue over the middle one: 0 is a perfect plane
  double entropy = 0.0;      ///< 0.5 ln det(2 pi e C), C in m^2
};

/// @param points at least 3
[[nodiscard]] PatchShape patch_shape(std::span<const geometry::Vec3> points);

struct MapShapeOptions {
  double thin_m = 0.05;           ///< one point per cube of this size; 0 keeps all
  double entropy_radius_m = 0.3;  ///< neighbourhood of the mean map entropy
  /// Neighbourhood of the thickness: a disc of this radius has the spread of a square of 0.6 m.
  double patch_radius_m = 0.3464;
  std::size_t neighbours_min = 10;
  double flatness_max = 0.1;  ///< patches above are not planar
};

/// Sharpness of a map without ground truth. Comparable only at equal options and similar density.
struct MapShape {
  std::size_t points = 0;        ///< after thinning
  std::size_t patches = 0;       ///< of them planar
  Statistics thickness;          ///< of planar patches [m]
  double thickness_p95_m = 0.0;  ///< reveals doubled walls
  std::size_t entropy_points = 0;
  std::optional<double> mme;  ///< mean map entropy; empty without neighbours
};

/// Source of the mean map entropy: Droeschel, Stueckler, Behnke, ICRA 2014.
[[nodiscard]] MapShape map_shape(const PointList& points, const MapShapeOptions& options,
                                 Executor& executor);

}  // namespace rali::eval
