#include "rali/fleet/path/shape.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace rali::fleet {

using geometry::Mat3;
using geometry::Mat6;

namespace {

Mat6 inverse_squares(double sigma_rad, double sigma_m) {
  Mat6 information = Mat6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  information.diagonal().tail<3>().setConstant(1.0 / (sigma_m * sigma_m));
  return information;
}

Mat3 fraction_of(const Mat3& information, const Mat3& weak) {
  return (information + weak).partialPivLu().solve(information);
}

}  // namespace

/// Where the scan leaves a translation unconstrained, the rotation is known except for the part
/// coupled to it: a scan also fits further along a bent passage, rotated by its bend. A longer step
/// also rotates more, so a gyroscope that measures the rotation measures the distance. Else
/// translation and rotation are independent.
Mat6 known_fraction(const Mat6& lidar_information, const ShapeSettings& s) {
  const Mat3 weak_turn = Mat3::Identity() / (s.known_rad * s.known_rad);
  const Mat3 weak_shift = Mat3::Identity() / (s.known_m * s.known_m);
  const Mat3 turn = lidar_information.topLeftCorner<3, 3>();
  const Mat3 shift = lidar_information.bottomRightCorner<3, 3>();
  const Mat3 both = lidar_information.topRightCorner<3, 3>();
  const Mat3 turn_inverse = (turn + weak_turn).inverse();
  Mat6 fraction = Mat6::Zero();
  fraction.topLeftCorner<3, 3>() =
      fraction_of(turn - both * (shift + weak_shift).inverse() * both.transpose(), weak_turn);
  fraction.bottomRightCorner<3, 3>() =
      fraction_of(shift - both.transpose() * turn_inverse * both, weak_shift);
  const Mat3 open = Mat3::Identity() - fraction.bottomRightCorner<3, 3>();
  fraction.topRightCorner<3, 3>() = fraction.topLeftCorner<3, 3>() * turn_inverse * both * open;
  return fraction;
}

Mat6 shape_information(const Mat6& lidar_information, const geometry::SE3& T_odom_before,
                       const ShapeSettings& s, double unseen_m2) {
  const Mat6 fraction = known_fraction(lidar_information, s);
  const double turn_rad = std::hypot(s.shape_rad, s.bend_radpm * std::sqrt(unseen_m2));
  const Mat6 I = fraction.transpose() * inverse_squares(turn_rad, s.shape_m) * fraction;
  Mat6 G = Mat6::Identity();
  G.block<3, 3>(3, 3) = T_odom_before.R;
  const Mat6 turned = G.transpose() * I * G;
  return 0.5 * (turned + turned.transpose());
}

double unseen_variance_m2(const Mat6& covariance_before, const Mat6& covariance) {
  const Mat6 grown = covariance - covariance_before;
  return std::max(0.0, grown.bottomRightCorner<3, 3>().trace());
}

double position_variance_m2(const Mat6& covariance, const geometry::Vec3& axis_odom) {
  return axis_odom.dot(covariance.bottomRightCorner<3, 3>() * axis_odom);
}

std::vector<Regained> regained(const Mat6& covariance_before, const Mat6& covariance,
                               const Mat6& lidar_information, const ShapeSettings& s) {
  // To at most half the sigma: then at least three quarters of the information are new.
  constexpr double kFall = 4.0;
  constexpr double kKnown = 0.5;  // better than a scan of `known_m`
  const Mat3 fraction = known_fraction(lidar_information, s).bottomRightCorner<3, 3>();
  const Mat3 fall = (covariance_before - covariance).bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Mat3> falls(fall);
  std::vector<Regained> out;
  for (int k = 0; k < 3; ++k) {
    const geometry::Vec3 axis = falls.eigenvectors().col(k);
    const double variance_m2 = position_variance_m2(covariance, axis);
    if (falls.eigenvalues()[k] < (kFall - 1.0) * (variance_m2 + s.loose_m * s.loose_m)) continue;
    if (axis.dot(fraction * axis) > kKnown) out.push_back({axis, variance_m2});
  }
  return out;
}

bool is_loose(const Mat6& lidar_information, const ShapeSettings& s) {
  const Mat6 I = shape_information(lidar_information, geometry::SE3{}, s);
  const auto weakest = [](const geometry::Mat3& block) {
    return Eigen::SelfAdjointEigenSolver<geometry::Mat3>(block, Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  };
  return weakest(I.topLeftCorner<3, 3>()) * s.loose_rad * s.loose_rad < 1.0 ||
         weakest(I.bottomRightCorner<3, 3>()) * s.loose_m * s.loose_m < 1.0;
}

void tie_by_filter(Mat6& shape, const Mat6& covariance_before, const Mat6& covariance,
                   const LeastSigma& least) {
  const Mat6 grown = covariance - covariance_before;
  const auto maximum = [](const Mat3& block) {
    return std::sqrt(std::max(
        0.0, Eigen::SelfAdjointEigenSolver<Mat3>(block, Eigen::EigenvaluesOnly).eigenvalues()[2]));
  };
  shape += inverse_squares(std::max(least.rad, maximum(grown.topLeftCorner<3, 3>())),
                           std::max(least.m, maximum(grown.bottomRightCorner<3, 3>())));
}

}  // namespace rali::fleet
