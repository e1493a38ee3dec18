#pragma once

#include <Eigen/Core>

#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Motion from one scan to the next, with the gravity that the accelerometer measured in it.
struct TiltStep {
  double span_s = 0.0;
  double travelled_m = 0.0;
  geometry::Mat3 R_odom_body = geometry::Mat3::Identity();
  /// Change of velocity that is not the integral of R_odom_body times specific force [m/s]:
  /// span_s times gravity in odom, less what the bias adds.
  geometry::Vec3 gravity_dv_mps = geometry::Vec3::Zero();
  double speed_sigma_mps = 0.0;  ///< of the velocity at the end
  double accel_noise_mps2_rthz = 0.0;
};

/// Tilt of odom since the first pose, measured by the accelerometer.
///
/// A map that is built scan by scan bends: lasers with elevation errors of 0.05 degrees tilt it by
/// up to 0.01 degrees per metre. No scan contradicts that, and the height is wrong by a metre after
/// 100 m. The odometry filter assumes a straight map and attributes the tilt to the accelerometer
/// bias. Here the bias is constant and the tilt is a random walk over the distance: a Kalman filter
/// with gravity at the first pose, bias and tilt, and one measurement every two seconds.
class MapTilt {
 public:
  /// @param bias_sigma_mps2  of the accelerometer's bias at turn-on
  explicit MapTilt(double bias_sigma_mps2);

  void add(const TiltStep& step);

  /// The next step does not follow the last one, or the LiDAR was degenerate in between.
  void interrupt();

  /// Rotation of odom against the horizontal since the first pose, about its x and y [rad]. The
  /// estimate is shrunk by its own variance: zero where noise explains all of it.
  [[nodiscard]] Eigen::Vector2d tilt_rad() const;

 private:
  static constexpr int kDim = 7;  // gravity at the first pose (x, y), bias (body), tilt (x, y)

  void measure();

  Eigen::Matrix<double, kDim, 1> x_;  ///< [m/s^2]
  Eigen::Matrix<double, kDim, kDim> P_;
  TiltStep sum_;                   ///< of the window; R_odom_body times its span
  double speed_before_mps_ = 0.0;  ///< sigma of the velocity at the window's start
};

}  // namespace rali::odometry
