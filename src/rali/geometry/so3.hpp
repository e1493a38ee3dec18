#pragma once

#include "rali/geometry/types.hpp"

namespace rali::geometry {

/// [a]x with [a]x b = a x b.
[[nodiscard]] Mat3 skew(const Vec3& a);

/// Rotation matrix of the rotation vector phi [rad] (Rodrigues).
[[nodiscard]] Mat3 so3_exp(const Vec3& phi);

/// Rotation vector [rad] of R, norm in [0, pi]; exact near 0 and near pi.
[[nodiscard]] Vec3 so3_log(const Mat3& R);

/// Right Jacobian: Exp(phi + d) = Exp(phi) Exp(Jr(phi) d) to first order in d.
/// Source: Forster et al. 2017, eq. (8).
[[nodiscard]] Mat3 so3_right_jacobian(const Vec3& phi);

/// Inverse of the right Jacobian, for |phi| < 2 pi.
[[nodiscard]] Mat3 so3_right_jacobian_inverse(const Vec3& phi);

/// Nearest rotation matrix (Frobenius): removes the rounding errors of long products.
[[nodiscard]] Mat3 so3_normalised(const Mat3& R);

/// The smallest rotation R with R a parallel to b; a and b need not be unit vectors.
/// Opposite vectors give a half turn about an axis perpendicular to a.
[[nodiscard]] Mat3 rotation_between(const Vec3& a, const Vec3& b);

/// R = Rz(yaw) Ry(pitch) Rx(roll), all in rad.
[[nodiscard]] Mat3 rotation_from_rpy(double roll_rad, double pitch_rad, double yaw_rad);

/// (roll, pitch, yaw) of R = Rz Ry Rx [rad]; yaw is 0 at gimbal lock.
[[nodiscard]] Vec3 rpy_from_rotation(const Mat3& R);

}  // namespace rali::geometry
