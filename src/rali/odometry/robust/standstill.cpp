#include "rali/odometry/robust/standstill.hpp"

#include <cmath>

#include "rali/odometry/robust/stillness.hpp"
#include "rali/odometry/robust/update.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Vec3;
using sensor::ImuSample;

namespace {

constexpr double kSpeedMax_mps = 0.05;
constexpr double kSpeedSigmaMax_mps = 0.1;
constexpr double kTravelMax_m = 0.01;
constexpr double kRateSigmas = 3.0;
constexpr double kZeroSpeedSigma_mps = 0.01;

}  // namespace

void StandstillDetector::learn(const imu::ImuStatistics& at_rest) { at_rest_ = at_rest; }

/// No more than the noise of the sensor, as its spread over a window varies by chance.
bool StandstillDetector::wheels_stand(const imu::ImuStatistics& raw) const {
  static constexpr double kSpreadMost = 1.25;
  if (!at_rest_ || raw.samples < 20) return false;
  const auto calm = [](const Vec3& now, const Vec3& rest) {
    return (now.array() < kSpreadMost * rest.array()).all();
  };
  return calm(raw.accel_sd_mps2, at_rest_->accel_sd_mps2) &&
         calm(raw.gyro_sd_radps, at_rest_->gyro_sd_radps);
}

bool StandstillDetector::update(const FilterState& state, const InertialBuffer& imu,
                                const std::optional<Vec3>& blind_axis) {
  recent_.push_back({state.t, state.T_odom_body.p});
  const Time begin = state.t - Duration::from_s(constraints_.rest_after_s);
  while (recent_.size() > 2 && recent_[1].t <= begin) recent_.pop_front();
  if (!constraints_.standstill || recent_.front().t > begin) return false;
  // Along a blind axis speed and travel are what the filter believes, not what anybody saw: there
  // the wheels decide.
  Mat3 seen = Mat3::Identity();
  if (blind_axis && wheels_stand(imu::statistics(imu.between(begin, state.t)))) {
    seen -= *blind_axis * blind_axis->transpose();
  }
  const Mat3 P_v = seen * state.P.block<3, 3>(kVel, kVel) * seen;
  if ((seen * state.v).norm() > kSpeedMax_mps ||
      P_v.diagonal().maxCoeff() > kSpeedSigmaMax_mps * kSpeedSigmaMax_mps) {
    return false;
  }
  for (const Moment& m : recent_) {
    if ((seen * (m.p - state.T_odom_body.p)).norm() > kTravelMax_m) return false;
  }
  const std::vector<ImuSample> window = imu.between(begin, state.t);
  const imu::ImuStatistics blocks = imu::statistics(block_means(window));
  if (blocks.samples < 4 || !is_quiet(blocks, rest_)) return false;
  // A vehicle that starts squats slowly: below the spread of the blocks, but not of their mean.
  const double sigma =
      noise_.gyro_radps_rthz * noise_.vibration_factor / std::sqrt(constraints_.rest_after_s);
  const double bias_var = state.P.block<3, 3>(kGyroBias, kGyroBias).diagonal().maxCoeff();
  const double limit = kRateSigmas * std::sqrt(sigma * sigma + bias_var);
  return (blocks.gyro_mean_radps - state.gyro_bias_radps).norm() < limit;
}

void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ImuNoiseSettings& noise) {
  const double dt_s = (t_end - state.t).s();
  if (dt_s <= 0.0) return;
  const imu::ImuStatistics stats = imu::statistics(buffer.between(state.t + Duration{1}, t_end));
  const ImuSample now = buffer.at(t_end);
  const Vec3 gyro = stats.samples > 0 ? stats.gyro_mean_radps : now.gyro_radps;
  const Vec3 accel = stats.samples > 0 ? stats.accel_mean_mps2 : now.accel_mps2;
  const Mat3& R = state.T_odom_body.R;
  const Vec3 a = accel - state.accel_bias_mps2;

  StateCov F = StateCov::Identity();
  F.block<3, 3>(kVel, kTheta) = -dt_s * R * geometry::skew(a);
  F.block<3, 3>(kVel, kAccelBias) = -dt_s * R;
  F.block<3, 2>(kVel, kGravity) =
      -dt_s * geometry::skew(state.g_odom_mps2) * gravity_basis(state.g_odom_mps2);
  propagate_covariance(state, F);
  const double white_a = noise.accel_mps2_rthz * noise.vibration_factor;
  const double white_g = noise.gyro_radps_rthz * noise.vibration_factor;
  state.P.diagonal().segment<3>(kVel).array() += white_a * white_a * dt_s;
  state.P.diagonal().segment<3>(kGyroBias).array() +=
      noise.gyro_walk_radps2_rthz * noise.gyro_walk_radps2_rthz * dt_s;
  state.P.diagonal().segment<3>(kAccelBias).array() +=
      noise.accel_walk_mps3_rthz * noise.accel_walk_mps3_rthz * dt_s;
  state.v += dt_s * (R * a + state.g_odom_mps2);
  state.t = t_end;

  using H3 = Eigen::Matrix<double, 3, kStateDim>;
  H3 H = H3::Zero();
  H.block<3, 3>(0, kVel).setIdentity();
  const Vec3 zero_speed = -state.v;
  update_linear<3>(state, H, zero_speed,
                   kZeroSpeedSigma_mps * kZeroSpeedSigma_mps * Mat3::Identity());
  H.setZero();
  H.block<3, 3>(0, kGyroBias).setIdentity();
  const Vec3 still = gyro - state.gyro_bias_radps;
  update_linear<3>(state, H, still, white_g * white_g / dt_s * Mat3::Identity());
}

}  // namespace rali::odometry
