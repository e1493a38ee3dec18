#include "rali/drive/closed_loop/own_pose.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace rali::drive {

fleet::OwnPose own_pose(const vehicle::PoseEstimate& pose, bool levelled) {
  fleet::OwnPose own;
  own.t = pose.t;
  own.T_odom_body = pose.T_odom_body;
  own.at_rest = pose.at_rest;
  own.levelled = levelled;
  own.degenerate = pose.degeneracy.degenerate;
  own.degenerate_odom = pose.degeneracy.degenerate_odom;
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> eigen(
      geometry::Mat3(pose.covariance.bottomRightCorner<3, 3>()), Eigen::EigenvaluesOnly);
  const double largest = eigen.eigenvalues().maxCoeff();
  own.sigma_m = std::isfinite(largest) && largest > 0.0 ? std::sqrt(largest) : 0.0;
  return own;
}

}  // namespace rali::drive
