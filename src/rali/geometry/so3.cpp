#include "rali/geometry/so3.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace rali::geometry {
namespace {

// Below this angle the series is exact to double precision.
constexpr double kSmallAngle = 1e-4;

}  // namespace

Mat3 skew(const Vec3& a) {
  Mat3 S;
  S << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return S;
}

Mat3 so3_exp(const Vec3& phi) {
  const double angle2 = phi.squaredNorm();
  const double angle = std::sqrt(angle2);
  double a = 1.0 - angle2 / 6.0;
  double b = 0.5 - angle2 / 24.0;
  if (angle > kSmallAngle) {
    a = std::sin(angle) / angle;
    const double half = std::sin(0.5 * angle) / angle;
    b = 2.0 * half * half;
  }
  const Mat3 S = skew(phi);
  return Mat3::Identity() + a * S + b * S * S;
}

Vec3 so3_log(const Mat3& R) {
  // Via the quaternion: its vector part is accurate both at small angles and near pi.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double n = q.vec().norm();
  if (n < 1e-10) return 2.0 * q.vec();
  return 2.0 * std::atan2(n, q.w()) / n * q.vec();
}

Mat3 so3_right_jacobian(const Vec3& phi) {
  const double angle2 = phi.squaredNorm();
  const double angle = std::sqrt(angle2);
  double a = 0.5 - angle2 / 24.0;
  double b = 1.0 / 6.0 - angle2 / 120.0;
  if (angle > kSmallAngle) {
    a = (1.0 - std::cos(angle)) / angle2;
    b = (angle - std::sin(angle)) / (angle2 * angle);
  }
  const Mat3 S = skew(phi);
  return Mat3::Identity() - a * S + b * S * S;
}

Mat3 so3_right_jacobian_inverse(const Vec3& phi) {
  const double angle2 = phi.squaredNorm();
  const double angle = std::sqrt(angle2);
  double b = 1.0 / 12.0 + angle2 / 720.0;
  if (angle > 1e-2) {
    const double half = 0.5 * angle;
    b = (1.0 - half / std::tan(half)) / angle2;
  }
  const Mat3 S = skew(phi);
  return Mat3::Identity() + 0.5 * S + b * S * S;
}

Mat3 so3_normalised(const Mat3& R) { return Eigen::Quaterniond(R).normalized().toRotationMatrix(); }

Mat3 rotation_between(const Vec3& a, const Vec3& b) {
  // Like Eigen's FromTwoVectors, but without its singular value decomposition for opposite vectors,
  // which takes longer to compile than the rest of this module.
  constexpr double kOpposite = 1e-12;
  const Vec3 from = a.normalized(), to = b.normalized();
  const double cosine = to.dot(from);
  if (cosine < -1.0 + kOpposite) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, from.unitOrthogonal()))
        .toRotationMatrix();
  }
  const double s = std::sqrt((1.0 + cosine) * 2.0);
  const Vec3 axis = from.cross(to) * (1.0 / s);
  return Eigen::Quaterniond(s * 0.5, axis.x(), axis.y(), axis.z()).toRotationMatrix();
}

Mat3 rotation_from_rpy(double roll_rad, double pitch_rad, double yaw_rad) {
  return (Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch_rad, Vec3::UnitY()) *
          Eigen::AngleAxisd(roll_rad, Vec3::UnitX()))
      .toRotationMatrix();
}

Vec3 rpy_from_rotation(const Mat3& R) {
  const double cos_pitch = std::hypot(R(2, 1), R(2, 2));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  // Gimbal lock: only the sum or difference of roll and yaw is defined, and the elements above are
  // rounding errors.
  if (cos_pitch < 1e-12) return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

}  // namespace rali::geometry
