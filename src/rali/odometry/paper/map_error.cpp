#include "rali/odometry/paper/map_error.hpp"

#include <Eigen/Eigenvalues>

namespace rali::odometry::paper {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

/// Directions with a larger sigma [m, rad] count as unconstrained by the registration.
constexpr double kKnownSigma = 0.3;
/// Motion [m] and rotation [rad] to expect while the vehicle is lost.
constexpr double kLostM = 5.0;
constexpr double kLostRad = 0.5;

/// Covariance in the directions with enough information, zero in the others.
Mat6 known_covariance(const Mat6& information) {
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(information);
  Vec6 variances = Vec6::Zero();
  for (int k = 0; k < 6; ++k) {
    const double value = solver.eigenvalues()(k);
    if (value > 1.0 / (kKnownSigma * kKnownSigma)) variances(k) = 1.0 / value;
  }
  return solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

void MapError::add_keyframe(const SE3& T_odom_body, const Mat6& information) {
  if (started_ && information.allFinite()) P_ = at(T_odom_body) + known_covariance(information);
  T_odom_keyframe_ = T_odom_body;
  started_ = true;
}

void MapError::add_along(const Vec3& e_odom, double variance_m2) {
  P_.bottomRightCorner<3, 3>() += variance_m2 * e_odom * e_odom.transpose();
}

void MapError::lose() {
  P_.diagonal().head<3>().array() += kLostRad * kLostRad;
  P_.diagonal().tail<3>().array() += kLostM * kLostM;
}

void MapError::know_along(const Vec3& e_odom, double sigma_m) {
  const Vec6 Ph = P_.rightCols<3>() * e_odom;
  const double variance_m2 = e_odom.dot(Ph.tail<3>());
  if (variance_m2 > 0.0) P_ -= Ph * Ph.transpose() / variance_m2;
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  add_along(e_odom, sigma_m * sigma_m);
}

Mat6 MapError::at(const SE3& T_odom_body) const {
  // theta in the body, p in odom: both poses have the same rigid error.
  Mat6 A = Mat6::Identity();
  A.topLeftCorner<3, 3>() = T_odom_body.R.transpose() * T_odom_keyframe_.R;
  A.bottomLeftCorner<3, 3>() =
      -geometry::skew(T_odom_body.p - T_odom_keyframe_.p) * T_odom_keyframe_.R;
  const Mat6 P = A * P_ * A.transpose();
  return 0.5 * (P + P.transpose());
}

}  // namespace rali::odometry::paper
