#pragma once

#include <span>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::imu {

using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat9 = Eigen::Matrix<double, 9, 9>;

/// Constant offsets of gyro and accelerometer, subtracted from each sample.
struct InertialBias {
  geometry::Vec3 gyro_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_mps2 = geometry::Vec3::Zero();
};

/// White noise densities of one axis.
struct InertialNoise {
  double gyro_radps_rthz = 1e-3;
  double accel_mps2_rthz = 1e-2;
};

/// Pose and velocity of the IMU in odom.
struct InertialState {
  geometry::Mat3 R_odom_imu = geometry::Mat3::Identity();
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
};

/// Residual between two states and its derivatives. Rows are (rotation, velocity, position);
/// columns of a pose are (rotation, position) as in geometry::boxplus, of the bias (gyro, accel).
struct InertialResidual {
  Vec9 r = Vec9::Zero();
  Eigen::Matrix<double, 9, 6> d_pose_i = Eigen::Matrix<double, 9, 6>::Zero();
  Eigen::Matrix<double, 9, 6> d_pose_j = Eigen::Matrix<double, 9, 6>::Zero();
  Eigen::Matrix<double, 9, 3> d_velocity_i = Eigen::Matrix<double, 9, 3>::Zero();
  Eigen::Matrix<double, 9, 3> d_velocity_j = Eigen::Matrix<double, 9, 3>::Zero();
  Eigen::Matrix<double, 9, 6> d_bias = Eigen::Matrix<double, 9, 6>::Zero();
};

/// Relative motion between two instants from inertial samples alone, independent of the state it
/// starts from (Forster et al. 2017, sections V and VI; paper section "IMU Pre-integration").
/// Samples are piecewise constant; rotation within a sample is taken at its middle.
class Preintegration {
 public:
  /// More samples than this are refused: at 200 Hz, 20 minutes between two keyframes.
  static constexpr std::size_t kSamplesMax = std::size_t{1} << 18U;
  /// A sample can cover at most this time.
  static constexpr double kStepMaxS = 1.0;

  Preintegration(const InertialBias& bias, const InertialNoise& noise);

  /// Appends a sample that holds for dt_s.
  /// @return false, and nothing is changed, if a number is not finite, dt_s is not in
  ///         (0, kStepMaxS] or kSamplesMax samples are in already.
  [[nodiscard]] bool add(const geometry::Vec3& gyro_radps, const geometry::Vec3& accel_mps2,
                         double dt_s);

  /// Appends the part of a stream that lies in [begin, end]. Each sample holds until the next, the
  /// last one until `end`, the first one from `begin` if it comes later.
  /// @return seconds covered; less than end - begin if samples were refused or there are none.
  double add_stream(std::span<const sensor::ImuSample> samples, Time begin, Time end);

  /// Discards all samples.
  void reset(const InertialBias& bias);

  // Deltas corrected to first order for another bias.
  [[nodiscard]] geometry::Mat3 delta_rotation(const InertialBias& bias) const;
  [[nodiscard]] geometry::Vec3 delta_velocity_mps(const InertialBias& bias) const;
  [[nodiscard]] geometry::Vec3 delta_position_m(const InertialBias& bias) const;

  /// State at the end of the samples.
  [[nodiscard]] InertialState predict(const InertialState& from, const geometry::Vec3& g_odom_mps2,
                                      const InertialBias& bias) const;

  /// r of algorithms.md 1.3 and all its derivatives.
  [[nodiscard]] InertialResidual residual(const InertialState& i, const InertialState& j,
                                          const geometry::Vec3& g_odom_mps2,
                                          const InertialBias& bias) const;

  [[nodiscard]] double duration_s() const { return duration_s_; }

  [[nodiscard]] std::size_t size() const { return samples_; }

  [[nodiscard]] const InertialBias& bias() const { return bias_; }

  /// Of (rotation, velocity, position), from white noise; bias random walk is not included.
  [[nodiscard]] const Mat9& covariance() const { return covariance_; }

  [[nodiscard]] const geometry::Mat3& d_rotation_d_gyro() const { return dRg_; }

  [[nodiscard]] const geometry::Mat3& d_velocity_d_gyro() const { return dvg_; }

  [[nodiscard]] const geometry::Mat3& d_velocity_d_accel() const { return dva_; }

  [[nodiscard]] const geometry::Mat3& d_position_d_gyro() const { return dpg_; }

  [[nodiscard]] const geometry::Mat3& d_position_d_accel() const { return dpa_; }

 private:
  struct Step {
    geometry::Vec3 gyro_radps;
    geometry::Vec3 accel_mps2;
    double dt_s;
  };

  void clear_sums();
  void integrate(const Step& step);
  void propagate_covariance(const geometry::Mat3& E, const geometry::Mat3& E_half,
                            const geometry::Mat3& Rm_ax, const geometry::Mat3& Rm,
                            const geometry::Vec3& w, double dt);

  InertialBias bias_;
  InertialNoise noise_;
  std::size_t samples_ = 0;

  double duration_s_ = 0.0;
  geometry::Mat3 dR_ = geometry::Mat3::Identity();
  geometry::Vec3 dv_ = geometry::Vec3::Zero();
  geometry::Vec3 dp_ = geometry::Vec3::Zero();
  geometry::Mat3 dRg_ = geometry::Mat3::Zero();
  geometry::Mat3 dvg_ = geometry::Mat3::Zero();
  geometry::Mat3 dva_ = geometry::Mat3::Zero();
  geometry::Mat3 dpg_ = geometry::Mat3::Zero();
  geometry::Mat3 dpa_ = geometry::Mat3::Zero();
  Mat9 covariance_ = Mat9::Zero();
};

}  // namespace rali::imu
