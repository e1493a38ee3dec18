#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "rali/geometry/se3.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using Vec4 = Eigen::Matrix<double, 4, 1>;
using Mat4 = Eigen::Matrix<double, 4, 4>;

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// To (-pi, pi].
[[nodiscard]] inline double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2.0 * std::numbers::pi);
}

/// Turns v by a quarter about z: the derivative of Rz by its angle is Rz S.
[[nodiscard]] inline geometry::Vec3 quarter_turn(const geometry::Vec3& v) {
  return {-v.y(), v.x(), 0.0};
}

/// Transform between two levelled frames: yaw and translation. Named T_a_b as an SE3 is.
struct YawPose {
  double yaw_rad = 0.0;
  geometry::Vec3 t_m = geometry::Vec3::Zero();

  /// Drops roll and pitch.
  [[nodiscard]] static YawPose of(const geometry::SE3& T) {
    return {std::atan2(T.R(1, 0) - T.R(0, 1), T.R(0, 0) + T.R(1, 1)), T.p};
  }

  [[nodiscard]] geometry::Vec3 turned(const geometry::Vec3& v) const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
  }

  [[nodiscard]] geometry::Vec3 operator*(const geometry::Vec3& p) const { return turned(p) + t_m; }

  [[nodiscard]] YawPose operator*(const YawPose& o) const {
    return {wrapped(yaw_rad + o.yaw_rad), *this * o.t_m};
  }

  [[nodiscard]] YawPose inverse() const {
    const YawPose back{-yaw_rad, geometry::Vec3::Zero()};
    return {wrapped(-yaw_rad), -back.turned(t_m)};
  }

  [[nodiscard]] geometry::SE3 se3() const {
    return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), t_m};
  }
};

}  // namespace rali::fleet
