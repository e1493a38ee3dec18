#include "rali/geometry/se3.hpp"

namespace rali::geometry {

SE3 boxplus(const SE3& T, const Vec6& delta) {
  return {T.R * so3_exp(delta.head<3>()), T.p + delta.tail<3>()};
}

Vec6 boxminus(const SE3& b, const SE3& a) {
  Vec6 delta;
  delta << so3_log(a.R.transpose() * b.R), b.p - a.p;
  return delta;
}

SE3 interpolate(const SE3& a, const SE3& b, double s) {
  return {a.R * so3_exp(s * so3_log(a.R.transpose() * b.R)), a.p + s * (b.p - a.p)};
}

Mat6 covariance_fixed_axes(const Mat6& cov_boxplus, const Mat3& R_outer_body) {
  Mat6 J = Mat6::Zero();
  J.block<3, 3>(0, 3).setIdentity();
  J.block<3, 3>(3, 0) = R_outer_body;
  return J * cov_boxplus * J.transpose();
}

}  // namespace rali::geometry
