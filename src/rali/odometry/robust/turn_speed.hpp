#pragma once

#include <optional>

#include "rali/geometry/types.hpp"

namespace rali::odometry {

/// The speed along a degenerate axis by the turn of a bend.
///
/// In a bend the LiDAR turns the vehicle for each metre of the estimated way; the gyro measures the
/// turn for each metre of the true one. Their difference is the bend times the
/// error of the way, also while the vehicle steers, which both measure alike. In a straight passage
/// it says nothing, as its variance shows.
class TurnSpeed {
 public:
  /// From one scan to the next.
  struct Step {
    double span_s = 0.0;
    double gyro_rad = 0.0;        ///< turn about up by the gyro, without its known bias
    double turn_rad = 0.0;        ///< turn about up by the estimate, without corrections by ranges
    double way_m = 0.0;           ///< along the axis, by the speed at that time
    double correction_mps = 0.0;  ///< by which measurements have changed the speed along the axis
    double bend_radpm = 0.0;      ///< turn per metre along the axis (Bend::here_radpm)
    double gyro_noise_radps_rthz = 0.0;
  };

  /// Linear in the error of the speed: residual_rad = rate_radpmps * (true - estimated) + noise.
  struct Measurement {
    double rate_radpmps = 0.0;  ///< turn that a speed of 1 m/s gives over the window
    double residual_rad = 0.0;
    double variance_rad2 = 0.0;
  };

  /// The gyro's bias while something other than a degenerate scan determines it.
  /// @param covariance of it [rad2/s2], in body
  void know(const geometry::Vec3& bias_radps, const geometry::Mat3& covariance);

  /// Of the last know().
  [[nodiscard]] double bias_variance(const geometry::Vec3& up_body) const {
    return up_body.dot(bias_covariance_ * up_body);
  }

  /// Of the last know().
  [[nodiscard]] const std::optional<geometry::Vec3>& bias_radps() const { return bias_radps_; }

  /// @param up_body unit @return a measurement each time that the vehicle has driven some metres
  [[nodiscard]] std::optional<Measurement> add(const Step& step, const geometry::Vec3& up_body);

  /// The next step does not follow on the last one.
  void interrupt() { window_ = {}; }

 private:
  /// Sums of the steps since the last measurement.
  struct Window {
    double span_s = 0.0, gyro_rad = 0.0, turn_rad = 0.0, way_m = 0.0, noise_rad2 = 0.0;
    double shift_m = 0.0;  ///< of the way, had each correction of the speed come at its start
  };

  std::optional<geometry::Vec3> bias_radps_;
  geometry::Mat3 bias_covariance_ = geometry::Mat3::Zero();
  int measurements_ = 0;  ///< with this bias
  Window window_;
};

}  // namespace rali::odometry
