#include "rali/odometry/make_odometry.hpp"

#include "rali/odometry/robust/robust_odometry.hpp"

namespace rali::odometry {

std::unique_ptr<Odometry> make_odometry(const OdometrySettings& settings,
                                        const sensor::Calibration& calibration, bool has_imu) {
  return make_robust_odometry(settings, calibration, has_imu);
}

}  // namespace rali::odometry
