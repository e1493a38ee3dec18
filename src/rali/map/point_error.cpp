#include "rali/map/point_error.hpp"

#include <algorithm>

namespace rali::map {

PointError::PointError(const geometry::Mat6& cov_boxplus, const geometry::Mat3& R_map_body) {
  const geometry::Mat3 rotation = cov_boxplus.topLeftCorner<3, 3>();
  const geometry::Mat3 M = cov_boxplus.topRightCorner<3, 3>() * R_map_body;
  quadratic_ = rotation.trace() * geometry::Mat3::Identity() - rotation;
  linear_ = -2.0 * geometry::Vec3{M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0)};
  constant_ = cov_boxplus.bottomRightCorner<3, 3>().trace();
}

double PointError::variance_m2(const geometry::Vec3& p_body) const {
  const double v = p_body.dot(quadratic_ * p_body) + linear_.dot(p_body) + constant_;
  return std::max(v, 0.0);  // rounding, or a covariance that is slightly indefinite
}

}  // namespace rali::map
