#include "rali/odometry/make_odometry.hpp"

#include "rali/odometry/body_frame.hpp"
#include "rali/odometry/paper/paper_odometry.hpp"
#include "rali/odometry/robust/robust_odometry.hpp"

namespace rali::odometry {

std::unique_ptr<Odometry> make_odometry(const OdometrySettings& settings,
                                        const sensor::Calibration& calibration, bool has_imu) {
  if (settings.preset == Preset::kPaper) {
    return make_paper_odometry(settings, calibration, has_imu);
  }
  const sensor::Calibration seen_from_imu = imu_calibration(calibration);
  const geometry::Vec3 forward_imu = calibration.T_body_imu.R.transpose().col(0);
  return in_body_frame(make_robust_odometry(settings, seen_from_imu, has_imu, forward_imu),
                       calibration.T_body_imu);
}

}  // namespace rali::odometry
