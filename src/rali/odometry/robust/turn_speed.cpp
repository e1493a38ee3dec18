#include "rali/odometry/robust/turn_speed.hpp"

#include <cmath>

namespace rali::odometry {

namespace {

/// Long enough for the turn of a bend to stand out, short enough for the speed error to be
/// constant.
constexpr double kWindow_m = 5.0;
/// By which a map turns in these metres: some ten registrations of 0.01 degrees.
constexpr double kMap_rad = 5e-4;
/// Of the gyro's scale: a cheap gyro may be off by 3 % (MPU-6000 specification, PS-MPU-6000A 6.1).
constexpr double kScale = 0.01;

}  // namespace

void TurnSpeed::know(const geometry::Vec3& bias_radps, const geometry::Mat3& covariance) {
  bias_radps_ = bias_radps;
  bias_covariance_ = covariance;
  measurements_ = 0;
  interrupt();
}

std::optional<TurnSpeed::Measurement> TurnSpeed::add(const Step& step,
                                                     const geometry::Vec3& up_body) {
  Window& w = window_;
  w.shift_m += step.correction_mps * w.span_s;
  w.span_s += step.span_s;
  w.gyro_rad += step.gyro_rad;
  w.turn_rad += step.turn_rad;
  w.way_m += step.way_m;
  w.noise_rad2 += std::pow(step.gyro_noise_radps_rthz, 2) * step.span_s;
  if (std::abs(w.way_m) < kWindow_m) return std::nullopt;
  ++measurements_;
  Measurement out;
  out.rate_radpmps = step.bend_radpm * w.span_s;
  out.residual_rad = w.gyro_rad - w.turn_rad - step.bend_radpm * w.shift_m;
  const double bias_rad2 = up_body.dot(bias_covariance_ * up_body) * w.span_s * w.span_s;
  // The error of the bias is the same in all windows: the k-th one counts a k-th of the first.
  out.variance_rad2 = w.noise_rad2 + measurements_ * bias_rad2 + kMap_rad * kMap_rad +
                      std::pow(kScale * w.gyro_rad, 2);
  interrupt();
  return out;
}

}  // namespace rali::odometry
