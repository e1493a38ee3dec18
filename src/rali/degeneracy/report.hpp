#pragma once

#include <array>
#include <optional>

#include "rali/geometry/types.hpp"

namespace rali::degeneracy {

enum class Category { kFull, kPartial, kNone };

/// The paper's measure (section "Geometry-based degeneration detection").
struct PaperDegree {
  bool known = false;   ///< false with fewer than deg_min_normals normals
  double degree = 0.0;  ///< ratio of eigenvalues by setting deg_ratio
  geometry::Vec3 e3_body = geometry::Vec3::Zero();  ///< eigenvector of lambda3, unit
  int normals = 0;
  bool degenerate = false;       ///< outside deg_below and deg_above, or not known
  bool direction_known = false;  ///< false if setting deg_direction yields none
  geometry::Vec3 direction_body = geometry::Vec3::Zero();  ///< unit; the direction to correct along
};

/// Observability of one physical direction by one scan.
struct DirectionInfo {
  geometry::Vec3 direction_odom = geometry::Vec3::Zero();  ///< unit; axis for rotations
  double information = 0.0;  ///< J_d, noise removed [1/m^2 or 1/rad^2]
  double raw = 0.0;          ///< I_d before noise removal
  /// B_d, the expected information from chance alone. raw / noise ranks scans for any sensor: it is
  /// about 1 without structure along the direction and above 2 with structure.
  double noise = 0.0;
  double sigma = 0.0;  ///< J_d^-1/2 [m or rad]; infinity if J_d = 0
  Category category = Category::kFull;
  int planes = 0;    ///< planes that support a translation (support.hpp); 0 for rotations
  int clusters = 0;  ///< number of clusters that these planes form
  /// Set if J_d is that of walls alone (walls.hpp): what they say about the motion.
  std::optional<double> wall_residual_m;
};

/// Both detectors on one scan. Source: algorithms 3.1 and 3.2.
struct Report {
  PaperDegree paper;
  /// axial (least observable horizontal), lateral, vertical; roll, pitch, yaw about the same axes.
  std::array<DirectionInfo, 6> directions;
  bool degenerate = false;  ///< a translation direction is kNone after hysteresis
  double sigma_degenerate_m =
      0.0;  ///< sigma of the worst translation direction; infinity without information
  geometry::Vec3 degenerate_odom = geometry::Vec3::Zero();  ///< its direction, unit
};

}  // namespace rali::degeneracy
