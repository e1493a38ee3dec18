#pragma once

#include <optional>
#include <vector>

#include "rali/odometry/imu_noise.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Mean acceleration of a vehicle over a start: the error of taking the mean force for gravity.
inline constexpr double kMeanForceSigma_mps2 = 0.7;

/// The same over `span_s`, in which the speed changes by about a metre per second.
[[nodiscard]] inline double mean_force_sigma_mps2(double span_s) {
  constexpr double kChange_mps = 1.0;
  return kChange_mps < kMeanForceSigma_mps2 * span_s ? kChange_mps / span_s : kMeanForceSigma_mps2;
}

/// A pose from the LiDAR alone, before gravity is known.
struct TrackedPose {
  Time t;
  geometry::SE3 T_odom_body;
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();  ///< of the position
};

struct InitialGuess {
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 v_first_mps = geometry::Vec3::Zero();  ///< at the start of the track
  double v_first_sigma_mps = 0.0;
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();
  geometry::Vec3 g_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);
  geometry::Mat3 velocity_covariance = geometry::Mat3::Zero();  ///< [(m/s)^2], in odom
  double gyro_bias_sigma_radps = 0.0;
  /// Accelerometer bias [m/s2] and direction of gravity [rad] as in FilterState. An error of one is
  /// compensated by the other; their sum is known well.
  Eigen::Matrix<double, 5, 5> bias_gravity_covariance = Eigen::Matrix<double, 5, 5>::Zero();
  bool at_rest = false;
  /// False: the track does not determine gravity and speed well enough yet.
  bool gravity_known = true;
};

/// Gravity, velocity and gyro bias at the end of `track` from inertial samples and LiDAR poses
/// (algorithms 1.4): at rest from means, in motion by linear least squares over the track.
/// @param same_view all scans show the same since the start: an idling engine may be what shakes
/// @param speed_usual_mps sigma of the first speed where the LiDAR is degenerate
/// @return empty while the data are too few
[[nodiscard]] std::optional<InitialGuess> solve_initial(
    const std::vector<TrackedPose>& track, const InertialBuffer& imu,
    const InitialisationSettings& settings, const ImuNoiseSettings& noise, bool same_view = false,
    double speed_usual_mps = ConstraintSettings{}.speed_usual_mps);

}  // namespace rali::odometry
