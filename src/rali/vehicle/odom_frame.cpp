#include "rali/vehicle/odom_frame.hpp"

#include <algorithm>

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

Vec3 limited(const Vec3& v, double most) {
  const double length = v.norm();
  return length > most ? Vec3(v * (most / length)) : v;
}

}  // namespace

SE3 OdomFrame::follow(const odometry::ScanResult& result) {
  const SE3 T_predicted_body = result.T_odom_body_predicted.inverse() * result.T_odom_body;
  // Without inertial data there is no motion but what the LiDAR sees.
  const bool measured = result.inertial || result.state == odometry::TrackState::kPredicted;
  const SE3 T_step =
      measured ? result.T_last_predicted : result.T_last_predicted * T_predicted_body;
  T_lidar_body_ =
      started_ ? T_lidar_body_ * result.T_last_predicted * T_predicted_body : result.T_odom_body;
  T_odom_body_ = started_ ? T_odom_body_ * T_step : result.T_odom_body;
  started_ = true;
  const Vec3 turn = geometry::so3_log(T_odom_body_.R.transpose() * T_lidar_body_.R);
  T_odom_body_.R =
      geometry::so3_normalised(T_odom_body_.R * geometry::so3_exp(limited(turn, limits_.turn_rad)));
  T_odom_body_.p += limited(T_lidar_body_.p - T_odom_body_.p, limits_.shift_m);
  T_lidar_body_.R = geometry::so3_normalised(T_lidar_body_.R);
  return T_odom_body_;
}

Mat6 odom_covariance(const Mat6& covariance_local, const SE3& T_local_body,
                     const SE3& T_odom_body) {
  // Rotation is perturbed in the body, position in the outer frame: only the latter turns.
  Mat6 J = Mat6::Identity();
  J.bottomRightCorner<3, 3>() = T_odom_body.R * T_local_body.R.transpose();
  Vec6 left_out;
  left_out << geometry::so3_log(T_local_body.R.transpose() * T_odom_body.R),
      T_odom_body.p - T_local_body.p;
  return J * covariance_local * J.transpose() + left_out * left_out.transpose();
}

}  // namespace rali::vehicle
