#pragma once

#include "rali/geometry/so3.hpp"

namespace rali::geometry {

/// A pose or rigid transform. T_a_b maps coordinates in b to coordinates in a:
/// p_a = T_a_b * p_b, and T_a_c = T_a_b * T_b_c.
struct SE3 {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();

  [[nodiscard]] SE3 inverse() const { return {R.transpose(), -(R.transpose() * p)}; }

  [[nodiscard]] SE3 operator*(const SE3& o) const { return {R * o.R, R * o.p + p}; }

  [[nodiscard]] Vec3 operator*(const Vec3& point) const { return R * point + p; }
};

/// The perturbation used everywhere in RaLI, tangent order (rotation, translation):
/// R <- R Exp(theta), p <- p + rho with rho in the outer frame (odom or map).
[[nodiscard]] SE3 boxplus(const SE3& T, const Vec6& delta);

/// The delta with boxplus(a, delta) = b.
[[nodiscard]] Vec6 boxminus(const SE3& b, const SE3& a);

/// Interpolation from a (s = 0) to b (s = 1): rotation at constant rate, position on the line.
[[nodiscard]] SE3 interpolate(const SE3& a, const SE3& b, double s);

/// Converts a covariance of `boxplus` (rotation in body, position in the outer frame) to that of
/// ROS PoseWithCovariance: order x y z rx ry rz, rotation about the fixed outer axes.
[[nodiscard]] Mat6 covariance_fixed_axes(const Mat6& cov_boxplus, const Mat3& R_outer_body);

}  // namespace rali::geometry
