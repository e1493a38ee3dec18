#include "rali/vehicle/odom_frame.hpp"

#include <algorithm>

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

Vec3 limited(const Vec3& v, double maximum) {
  const double length = v.norm();
  return length > maximum ? Vec3(v * (maximum / length)) : v;
}

}  // namespace

OdomLimits OdomFrame::limits_for(const odometry::ScanResult& result) const {
  OdomLimits out = limits_;
  if (result.inertial) return out;
  const double dt_s = std::clamp(seconds_between(t_, result.t), 0.0, limits_.scan_max_s);
  out.shift_m = std::max(out.shift_m, limits_.accel_mps2 * dt_s * dt_s);
  out.turn_rad = std::max(out.turn_rad, limits_.accel_radps2 * dt_s * dt_s);
  return out;
}

SE3 OdomFrame::follow(const odometry::ScanResult& result) {
  if (!started_) {
    started_ = true;
    t_ = result.t;
    T_lidar_body_ = T_odom_body_ = result.T_odom_body;
    return T_odom_body_;
  }
  const OdomLimits limits = limits_for(result);
  t_ = result.t;
  if (result.new_map) {
    // The reset of the pose is no motion, and the prediction is what led to the loss.
    T_lidar_body_ = T_odom_body_;
    return T_odom_body_;
  }
  const SE3 T_predicted_body = result.T_odom_body_predicted.inverse() * result.T_odom_body;
  T_lidar_body_ = T_lidar_body_ * result.T_last_predicted * T_predicted_body;
  T_odom_body_ = T_odom_body_ * result.T_last_predicted;
  const Vec3 turn = geometry::so3_log(T_odom_body_.R.transpose() * T_lidar_body_.R);
  T_odom_body_.R =
      geometry::so3_normalised(T_odom_body_.R * geometry::so3_exp(limited(turn, limits.turn_rad)));
  T_odom_body_.p += limited(T_lidar_body_.p - T_odom_body_.p, limits.shift_m);
  T_lidar_body_.R = geometry::so3_normalised(T_lidar_body_.R);
  return T_odom_body_;
}

Mat6 odom_covariance(const Mat6& covariance_local, const SE3& T_local_body,
                     const SE3& T_odom_body) {
  // Rotation is perturbed in the body, position in the outer frame: only the latter is rotated.
  Mat6 J = Mat6::Identity();
  J.bottomRightCorner<3, 3>() = T_odom_body.R * T_local_body.R.transpose();
  Vec6 left_out;
  left_out << geometry::so3_log(T_local_body.R.transpose() * T_odom_body.R),
      T_odom_body.p - T_local_body.p;
  return J * covariance_local * J.transpose() + left_out * left_out.transpose();
}

}  // namespace rali::vehicle
