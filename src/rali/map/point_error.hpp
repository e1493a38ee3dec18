#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::map {

/// Expected squared position error of points placed by an uncertain pose.
///
/// p_map = R p + t with the perturbation of geometry::boxplus has the Jacobian
/// J = [-R [p]x, I], so the trace of J P J' is a quadratic form in p: p'Qp + b'p + c, with
/// Q = tr(P_tt) I - P_tt, M = P_tr R, b = -2 (M12-M21, M20-M02, M01-M10), c = tr(P_rr); t is the
/// rotation block, r the translation block. One multiplication per point instead of a 3x6 product.
class PointError {
 public:
  PointError(const geometry::Mat6& cov_boxplus, const geometry::Mat3& R_map_body);

  /// E |error|^2 [m^2] of a point given in body.
  [[nodiscard]] double variance_m2(const geometry::Vec3& p_body) const;

 private:
  geometry::Mat3 quadratic_;
  geometry::Vec3 linear_;
  double constant_;
};

}  // namespace rali::map
