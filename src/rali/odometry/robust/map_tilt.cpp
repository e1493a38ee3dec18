#include "rali/odometry/robust/map_tilt.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace rali::odometry {

namespace {

constexpr double kGravity_mps2 = 9.81;
constexpr double kDegree = std::numbers::pi / 180.0;
/// Ends of a window are velocities: shorter ones are mostly their noise.
constexpr double kWindow_s = 2.0;
/// Prior of gravity at the first pose: loose, since that pose need not be level.
constexpr double kLevelSigma_mps2 = 0.5 * kGravity_mps2;
/// How fast a map bends: 0.01 degrees per metre is followed within 20 m.
constexpr double kWalk_deg_rtm = 0.03;

}  // namespace

MapTilt::MapTilt(double bias_sigma_mps2) {
  x_.setZero();
  P_.setZero();
  P_.diagonal().head<2>().setConstant(kLevelSigma_mps2 * kLevelSigma_mps2);
  P_.diagonal().segment<3>(2).setConstant(bias_sigma_mps2 * bias_sigma_mps2);
  interrupt();
}

void MapTilt::interrupt() {
  sum_ = {};
  sum_.R_odom_body.setZero();
  speed_before_mps_ = -1.0;
}

void MapTilt::add(const TiltStep& step) {
  const double walk_mps2 = kGravity_mps2 * kWalk_deg_rtm * kDegree;
  P_.diagonal().tail<2>().array() += walk_mps2 * walk_mps2 * step.travelled_m;
  if (speed_before_mps_ < 0.0) {  // its velocity starts a window
    speed_before_mps_ = step.speed_sigma_mps;
    return;
  }
  sum_.span_s += step.span_s;
  sum_.R_odom_body += step.span_s * step.R_odom_body;
  sum_.gravity_dv_mps += step.gravity_dv_mps;
  sum_.speed_sigma_mps = step.speed_sigma_mps;
  sum_.accel_noise_mps2_rthz = std::max(sum_.accel_noise_mps2_rthz, step.accel_noise_mps2_rthz);
  if (sum_.span_s >= kWindow_s) measure();
}

void MapTilt::measure() {
  const double span_s = sum_.span_s;
  Eigen::Matrix<double, 2, kDim> H;
  H.leftCols<2>().setIdentity();
  H.middleCols<3>(2) = -sum_.R_odom_body.topRows<2>() / span_s;
  H.rightCols<2>().setIdentity();
  const double variance =
      std::pow(sum_.accel_noise_mps2_rthz, 2) / span_s +
      (std::pow(sum_.speed_sigma_mps, 2) + std::pow(speed_before_mps_, 2)) / (span_s * span_s);
  const Eigen::Vector2d residual = sum_.gravity_dv_mps.head<2>() / span_s - H * x_;
  const Eigen::Matrix<double, kDim, 2> PHt = P_ * H.transpose();
  const Eigen::Matrix2d S = H * PHt + variance * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, kDim, 2> K = S.llt().solve(PHt.transpose()).transpose();
  x_ += K * residual;
  P_ -= K * PHt.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  const double speed_sigma = sum_.speed_sigma_mps;
  interrupt();
  speed_before_mps_ = speed_sigma;
}

Eigen::Vector2d MapTilt::tilt_rad() const {
  const Eigen::Vector2d g = x_.tail<2>();
  const Eigen::Matrix2d P = P_.bottomRightCorner<2, 2>();
  const double chi2 = P.isZero(0.0) ? 0.0 : g.dot(P.llt().solve(g));
  if (!(chi2 > 2.0)) return Eigen::Vector2d::Zero();
  // A tilt turns gravity: dg = phi x g.
  return (1.0 - 2.0 / chi2) / kGravity_mps2 * Eigen::Vector2d(g.y(), -g.x());
}

}  // namespace rali::odometry
