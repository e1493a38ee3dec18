#include "rali/odometry/mounting.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;

// With E the rotation error of the LiDAR in the body, a path T is estimated as E T E^-1.
Mat6 mounting_covariance(const SE3& T_odom_first, const SE3& T_odom_body, double sigma_rad) {
  Eigen::Matrix<double, 6, 3> J;
  J.topRows<3>() = T_odom_body.R.transpose() * T_odom_first.R - Mat3::Identity();
  J.bottomRows<3>() = -geometry::skew(T_odom_body.p - T_odom_first.p) * T_odom_first.R;
  return sigma_rad * sigma_rad * J * J.transpose();
}

}  // namespace rali::odometry
