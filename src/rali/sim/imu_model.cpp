#include "rali/sim/imu_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace rali::sim {

using geometry::Vec3;

namespace {

Vec3 normal3(Rng& rng) {
  const double x = rng.normal();
  const double y = rng.normal();
  const double z = rng.normal();
  return {x, y, z};
}

}  // namespace

ImuOptions ImuOptions::ideal() {
  ImuOptions o;
  o.gyro_radps_rthz = o.accel_mps2_rthz = 0.0;
  o.gyro_walk_radps2_rthz = o.accel_walk_mps3_rthz = 0.0;
  o.gyro_bias_radps = o.accel_bias_mps2 = 0.0;
  o.vibration_gyro_radps = o.vibration_accel_mps2 = 0.0;
  return o;
}

sensor::ImuSample ideal_imu(Time t, const MotionState& state, const geometry::SE3& T_body_imu) {
  const Vec3& w = state.omega_body_radps;
  const Vec3& lever = T_body_imu.p;
  const Vec3 a_lever_body = state.alpha_body_radps2.cross(lever) + w.cross(w.cross(lever));
  const Vec3 gravity(0.0, 0.0, -kGravity_mps2);
  const Vec3 force_body =
      state.T_world_body.R.transpose() * (state.a_world_mps2 - gravity) + a_lever_body;
  sensor::ImuSample sample;
  sample.t = t;
  sample.gyro_radps = T_body_imu.R.transpose() * w;
  sample.accel_mps2 = T_body_imu.R.transpose() * force_body;
  return sample;
}

Vec3 ImuModel::Vibration::next(Rng& rng, double rate_hz) {
  const double c = std::cos(2.0 * std::numbers::pi * centre_hz / rate_hz);
  const double a1 = 2.0 * radius * c;
  const double a2 = -radius * radius;
  // Variance of an AR(2) process driven by unit noise (Box, Jenkins: Time Series Analysis, 3.2).
  const double variance = (1.0 - a2) / ((1.0 + a2) * ((1.0 - a2) * (1.0 - a2) - a1 * a1));
  const Vec3 value = a1 * last + a2 * before + normal3(rng);
  before = last;
  last = value;
  return value / std::sqrt(variance);
}

Vec3 ImuModel::Resonances::next(Rng& rng, double rate_hz) {
  Vec3 sum = Vec3::Zero();
  for (Vibration& mode : modes) sum += mode.next(rng, rate_hz);
  return sum / std::sqrt(static_cast<double>(modes.size()));
}

ImuModel::Resonances ImuModel::draw_resonances(Rng& rng) const {
  constexpr int kModes = 3;
  constexpr double kQuality = 15.0;  // centre over width: bolted sheet metal
  Resonances out;
  for (int i = 0; i < kModes; ++i) {
    Vibration mode;
    mode.centre_hz = rng.uniform(options_.resonance_low_hz, options_.resonance_high_hz);
    mode.radius = std::exp(-std::numbers::pi * mode.centre_hz / (kQuality * options_.rate_hz));
    out.modes.push_back(mode);
  }
  return out;
}

ImuModel::ImuModel(const ImuOptions& options, std::uint64_t seed)
    : options_(options),
      white_(seed, "imu white"),
      walk_(seed, "imu walk"),
      shake_(seed, "imu shake"),
      ring_(seed, "imu resonances") {
  Rng triads(seed, "imu triads");
  const double tilt_rad = options_.misalignment_deg * std::numbers::pi / 180.0;
  R_gyro_ = geometry::so3_exp(tilt_rad * normal3(triads).normalized());
  R_accel_ = geometry::so3_exp(tilt_rad * normal3(triads).normalized());
  gyro_resonances_ = draw_resonances(ring_);
  accel_resonances_ = draw_resonances(ring_);
  Rng bias(seed, "imu bias");
  gyro_bias_ = options_.gyro_bias_radps * normal3(bias);
  accel_bias_ = options_.accel_bias_mps2 * normal3(bias);
}

sensor::ImuSample ImuModel::measure(const sensor::ImuSample& ideal, double speed_mps) {
  const double root_rate = std::sqrt(options_.rate_hz);
  gyro_bias_ += options_.gyro_walk_radps2_rthz / root_rate * normal3(walk_);
  accel_bias_ += options_.accel_walk_mps3_rthz / root_rate * normal3(walk_);
  const Vec3 gyro_white = options_.gyro_radps_rthz * root_rate * normal3(white_);
  const Vec3 accel_white = options_.accel_mps2_rthz * root_rate * normal3(white_);
  const Vec3 gyro_shake =
      options_.vibration_gyro_radps * speed_mps * gyro_vibration_.next(shake_, options_.rate_hz);
  const Vec3 accel_shake =
      options_.vibration_accel_mps2 * speed_mps * accel_vibration_.next(shake_, options_.rate_hz);
  // The resonances fade out towards standstill.
  constexpr double kRings_mps = 0.1;
  const double ringing = std::min(1.0, speed_mps / kRings_mps);
  Vec3 gyro_ring = Vec3::Zero();
  Vec3 accel_ring = Vec3::Zero();
  if (options_.resonance_gyro_radps > 0.0 || options_.resonance_accel_mps2 > 0.0) {
    gyro_ring =
        ringing * options_.resonance_gyro_radps * gyro_resonances_.next(ring_, options_.rate_hz);
    accel_ring =
        ringing * options_.resonance_accel_mps2 * accel_resonances_.next(ring_, options_.rate_hz);
  }
  const double scale = 1.0 + options_.scale_error;
  const double gl = options_.gyro_limit_radps;
  const double al = options_.accel_limit_mps2;
  const Vec3 gyro =
      scale * (R_gyro_ * ideal.gyro_radps) + gyro_bias_ + gyro_white + gyro_shake + gyro_ring;
  const Vec3 accel =
      scale * (R_accel_ * ideal.accel_mps2) + accel_bias_ + accel_white + accel_shake + accel_ring;
  sensor::ImuSample out;
  out.t = ideal.t + Duration::from_s(options_.time_offset_s);
  out.gyro_radps = gyro.cwiseMax(-gl).cwiseMin(gl);
  out.accel_mps2 = accel.cwiseMax(-al).cwiseMin(al);
  if (options_.gyro_in_degps) out.gyro_radps *= 180.0 / std::numbers::pi;
  if (options_.accel_in_g) out.accel_mps2 /= kGravity_mps2;
  return out;
}

}  // namespace rali::sim
