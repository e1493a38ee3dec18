#include "rali/fleet/path/level.hpp"

#include <Eigen/Geometry>

namespace rali::fleet {

geometry::SE3 level_start(const geometry::SE3& T_odom_first, const geometry::Vec3& up_odom) {
  const geometry::Vec3 forward = T_odom_first.R.col(0);
  const geometry::Vec3 x = (forward - forward.dot(up_odom) * up_odom).normalized();
  geometry::SE3 T;
  T.R.col(0) = x;
  T.R.col(1) = up_odom.cross(x);
  T.R.col(2) = up_odom;
  T.p = T_odom_first.p;
  return T;
}

}  // namespace rali::fleet
