#pragma once

#include "rali/geometry/types.hpp"

namespace rali::geometry {

/// Eigen-decomposition of a symmetric 3x3 matrix, largest eigenvalue first.
struct Pca3 {
  Vec3 values;   ///< l1 >= l2 >= l3 (not clamped: rounding may leave l3 slightly below 0)
  Mat3 vectors;  ///< columns e1, e2, e3, orthonormal, right-handed
};

/// @param S symmetric; only the lower triangle is read.
[[nodiscard]] Pca3 pca3(const Mat3& S);

}  // namespace rali::geometry
