#include "rali/fleet/path/shape.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace rali::fleet {

using geometry::Mat6;

namespace {

Mat6 inverse_squares(double sigma_rad, double sigma_m) {
  Mat6 information = Mat6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  information.diagonal().tail<3>().setConstant(1.0 / (sigma_m * sigma_m));
  return information;
}

}  // namespace

Mat6 known_share(const Mat6& lidar_information, const ShapeSettings& s) {
  const Mat6 weak = inverse_squares(s.known_rad, s.known_m);
  return (lidar_information + weak).partialPivLu().solve(lidar_information);
}

Mat6 shape_information(const Mat6& lidar_information, const geometry::SE3& T_odom_before,
                       const ShapeSettings& s) {
  const Mat6 share = known_share(lidar_information, s);
  const Mat6 I = share.transpose() * inverse_squares(s.shape_rad, s.shape_m) * share;
  Mat6 G = Mat6::Identity();
  G.block<3, 3>(3, 3) = T_odom_before.R;
  const Mat6 turned = G.transpose() * I * G;
  return 0.5 * (turned + turned.transpose());
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

void loosen_gap(Mat6& shape, const ShapeSettings& s) {
  shape += inverse_squares(s.known_rad, s.gap_m);
}

}  // namespace rali::fleet
