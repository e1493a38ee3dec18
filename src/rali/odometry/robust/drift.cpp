#include "rali/odometry/robust/drift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;

namespace {

/// Left perturbation of the pose that a boxplus error is: phi = R theta, rho = dp + p x phi.
Mat6 left_from_boxplus(const SE3& T) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = T.R;
  A.block<3, 3>(3, 0) = geometry::skew(T.p) * T.R;
  A.block<3, 3>(3, 3).setIdentity();
  return A;
}

Mat6 boxplus_from_left(const SE3& T) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = T.R.transpose();
  A.block<3, 3>(3, 0) = -geometry::skew(T.p);
  A.block<3, 3>(3, 3).setIdentity();
  return A;
}

}  // namespace

Drift::Drift(const DriftSettings& settings) : settings_(settings), D_(1, Mat6::Zero()) {
  // Sparse rings at rest see pitch and roll poorly: the map grows on a frame that is turned
  // against the first pose by about this much.
  const double sigma_rad = settings.start_sigma_deg * std::numbers::pi / 180.0;
  D_[0].diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  D_[0].diagonal().tail<3>().setConstant(settings.start_sigma_m * settings.start_sigma_m);
}

Mat6 Drift::update(const SE3& T_odom_body, double mean_epoch, const Mat6& P_local,
                   const Mat6& share) {
  const double last = static_cast<double>(D_.size() - 1);
  const double at = std::clamp(mean_epoch, 0.0, last);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, D_.size() - 1);
  const double f = at - static_cast<double>(below);
  const Mat6 D_reference = (1.0 - f) * D_[below] + f * D_[above];
  const Mat6 B = boxplus_from_left(T_odom_body);
  map_error_ = share * B * D_reference * B.transpose() * share.transpose();
  if ((T_odom_body.p - p_epoch_).norm() > settings_.epoch_m) {
    p_epoch_ = T_odom_body.p;
    ++epoch_;
    const Mat6 A = left_from_boxplus(T_odom_body);
    const Mat6 registered = share * P_local * share.transpose();
    const Mat6 inherited = map_error_ + P_local + (settings_.growth - 1.0) * registered;
    D_.push_back(A * inherited * A.transpose());
  }
  return map_error_ + P_local;
}

void Drift::add(const SE3& T_odom_body, const Mat6& P) {
  const Mat6 A = left_from_boxplus(T_odom_body);
  p_epoch_ = T_odom_body.p;
  ++epoch_;
  D_.push_back(D_.back() + A * P * A.transpose());
}

}  // namespace rali::odometry
