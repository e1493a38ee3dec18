#include "rali/odometry/body_augmented_filter.hpp"

#include <Eigen/Geometry>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

Mat6 body_jacobian(const SE3& T_inner_imu, const SE3& T_imu_body, const Mat3& R_odom_inner) {
  Mat6 J = Mat6::Zero();
  J.block<3, 3>(0, 0) = T_imu_body.R.transpose();
  J.block<3, 3>(3, 0) = -R_odom_inner * T_inner_imu.R * geometry::skew(T_imu_body.p);
  J.block<3, 3>(3, 3) = R_odom_inner;
  return J;
}

std::optional<Moment> BodyAugmentedFilter::advance_to(Time t) {
  const std::optional<Moment> inside = inner_.advance_to(t);
  if (!inside) return std::nullopt;
  T_inner_imu_ = inside->T_odom_body;
  Moment out = *inside;
  out.T_odom_body = T_odom_inner_ * T_inner_imu_ * T_imu_body_;
  out.v_odom_mps = T_odom_inner_.R * (inside->v_odom_mps +
                                      T_inner_imu_.R * inside->w_body_radps.cross(T_imu_body_.p));
  out.w_body_radps = T_imu_body_.R.transpose() * inside->w_body_radps;
  return out;
}

/// The derivatives neglect the speed from rotation about the lever arm: it only acts through the
/// stamps' offset, times milliseconds.
AugmentedMeasurement BodyAugmentedFilter::seen_inside(
    const AugmentedMeasurement& measurement) const {
  AugmentedMeasurement out = measurement;
  out.d_pose = measurement.d_pose * body_jacobian(T_inner_imu_, T_imu_body_, T_odom_inner_.R);
  out.d_velocity = measurement.d_velocity * T_odom_inner_.R;
  return out;
}

AugmentedRowList BodyAugmentedFilter::seen_inside(const AugmentedRowList& rows) const {
  AugmentedRowList out;
  out.reserve(rows.size());
  for (const AugmentedMeasurement& row : rows) out.push_back(seen_inside(row));
  return out;
}

std::optional<Vec3> BodyAugmentedFilter::degenerate_axis() const {
  const std::optional<Vec3> inside = inner_.degenerate_axis();
  if (!inside) return std::nullopt;
  return Vec3(T_odom_inner_.R * *inside);
}

int BodyAugmentedFilter::surfaces_between(const Vec3& p_odom_m, const Vec3& q_odom_m) const {
  const SE3 T_inner_odom = T_odom_inner_.inverse();
  return inner_.surfaces_between(T_inner_odom * p_odom_m, T_inner_odom * q_odom_m);
}

Mat3 BodyAugmentedFilter::position_covariance() const {
  return T_odom_inner_.R * inner_.position_covariance() * T_odom_inner_.R.transpose();
}

}  // namespace rali::odometry
