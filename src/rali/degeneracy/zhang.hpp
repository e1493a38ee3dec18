#pragma once

#include "rali/geometry/types.hpp"

namespace rali::degeneracy {

/// Degeneracy factors of Zhang, Kaess, Singh (ICRA 2016): eigenvalues of J^T J of a registration in
/// which every match has weight 1. Kept for comparison and for odometry without a prior: the scale
/// of a threshold depends on sensor, sampling and scene, and rotation and translation are mixed
/// (algorithms 3.5).
class ZhangFactors {
 public:
  /// @param JtJ sum of h^T h with h = (p x n, n), boxplus order; symmetric, only its lower
  /// triangle is read. A matrix with values that are not finite is treated as zero.
  explicit ZhangFactors(const geometry::Mat6& JtJ);

  /// Eigenvalues, smallest first, never below 0.
  [[nodiscard]] const geometry::Vec6& factors() const { return factors_; }

  /// Smallest eigenvalue of the translation block: J^T J of a registration with fixed rotation.
  [[nodiscard]] double translation() const { return translation_; }

  /// Its direction, unit, in the frame of the normals.
  [[nodiscard]] const geometry::Vec3& translation_direction() const { return direction_; }

  /// Number of directions with a factor below the threshold.
  [[nodiscard]] int degenerate(double threshold) const;

 private:
  geometry::Vec6 factors_;
  double translation_ = 0.0;
  geometry::Vec3 direction_ = geometry::Vec3::UnitX();
};

}  // namespace rali::degeneracy
