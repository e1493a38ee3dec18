#include "rali/odometry/robust/standstill.hpp"

#include <algorithm>
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
constexpr double kDrives_mps = 0.3;  // the LiDAR sees the vehicle drive

}  // namespace

void StandstillDetector::learn(const imu::ImuStatistics& at_rest) { at_rest_ = at_rest; }

/// No more than the noise of the sensor, as its spread over a window varies by chance.
bool StandstillDetector::wheels_stand(const imu::ImuStatistics& raw) const {
  static constexpr double kSpreadMost = 1.3;
  if (!at_rest_ || raw.samples < 20) return false;
  const auto calm = [](const Vec3& now, const Vec3& rest) {
    return (now.array() < kSpreadMost * rest.array()).all();
  };
  return calm(raw.accel_sd_mps2, at_rest_->accel_sd_mps2) &&
         calm(raw.gyro_sd_radps, at_rest_->gyro_sd_radps);
}

/// The calmest stretch of driving shakes the sensor well beyond its spread at standstill.
bool StandstillDetector::driving_shakes() const {
  constexpr double kFactor = 1.8;
  return at_rest_ && (driving_accel_mps2_ > kFactor * at_rest_->accel_sd_mps2.norm() ||
                      driving_gyro_radps_ > kFactor * at_rest_->gyro_sd_radps.norm());
}

void StandstillDetector::learn_driving(const FilterState& state, const imu::ImuStatistics& raw) {
  const double sigma2 = state.P.block<3, 3>(kVel, kVel).diagonal().maxCoeff();
  const bool drives =
      state.v.norm() > kDrives_mps && sigma2 < kSpeedSigmaMax_mps * kSpeedSigmaMax_mps;
  if (!drives || raw.samples < 20) return;
  // A low quantile, slowly followed: a pose that slides while the vehicle stands looks like calm
  // driving and must not teach that there is such.
  constexpr double kQuantile = 0.2;
  constexpr double kStep = 0.01;
  const auto track = [](double& low, double now) {
    low = low > 0.0 ? low * std::exp(kStep * (kQuantile - (now < low ? 1.0 : 0.0))) : now;
  };
  track(driving_accel_mps2_, raw.accel_sd_mps2.norm());
  track(driving_gyro_radps_, raw.gyro_sd_radps.norm());
}

void StandstillDetector::learn_standing(Time t, bool stands, const imu::ImuStatistics& raw) {
  if (!stands) return stands_since_.reset();
  if (!stands_since_) stands_since_ = t;
  const bool long_enough = (t - *stands_since_).s() > 2.0 * constraints_.rest_after_s;
  if (!long_enough || raw.samples < 20) return;
  if (!at_rest_) at_rest_ = raw;
  constexpr double kGain = 0.02;  // the spread of one window varies by chance
  at_rest_->accel_sd_mps2 += kGain * (raw.accel_sd_mps2 - at_rest_->accel_sd_mps2);
  at_rest_->gyro_sd_radps += kGain * (raw.gyro_sd_radps - at_rest_->gyro_sd_radps);
}

bool StandstillDetector::moves_visibly(const FilterState& state, const Mat3& seen) const {
  const Mat3 P_v = seen * state.P.block<3, 3>(kVel, kVel) * seen;
  if ((seen * state.v).norm() > kSpeedMax_mps ||
      P_v.diagonal().maxCoeff() > kSpeedSigmaMax_mps * kSpeedSigmaMax_mps) {
    return true;
  }
  for (const Moment& m : recent_) {
    if ((seen * (m.p - state.T_odom_body.p)).norm() > kTravelMax_m) return true;
  }
  return false;
}

/// A vehicle that starts squats slowly: below the spread of the blocks, but not of their mean.
bool StandstillDetector::turns(const FilterState& state, const imu::ImuStatistics& blocks,
                               double gyro_radps_rthz) const {
  const double sigma = gyro_radps_rthz / std::sqrt(constraints_.rest_after_s);
  const double bias_var = state.P.block<3, 3>(kGyroBias, kGyroBias).diagonal().maxCoeff();
  const double limit = kRateSigmas * std::sqrt(sigma * sigma + bias_var);
  return !((blocks.gyro_mean_radps - state.gyro_bias_radps).norm() < limit);
}

bool StandstillDetector::update(const FilterState& state, const InertialBuffer& imu,
                                const std::optional<Vec3>& blind_axis, double gyro_radps_rthz) {
  certain_ = false;
  recent_.push_back({state.t, state.T_odom_body.p});
  const Time begin = state.t - Duration::from_s(constraints_.rest_after_s);
  while (recent_.size() > 2 && recent_[1].t <= begin) recent_.pop_front();
  if (!constraints_.standstill || recent_.front().t > begin) return false;
  const std::vector<ImuSample> window = imu.between(begin, state.t);
  const imu::ImuStatistics raw = imu::statistics(window);
  const imu::ImuStatistics blocks = imu::statistics(block_means(window));
  learn_driving(state, raw);
  const bool calm = blocks.samples >= 4 && is_quiet(blocks, rest_);
  const bool wheels = wheels_stand(raw);
  const bool quiet = calm && !turns(state, blocks, gyro_radps_rthz);
  certain_ = quiet && wheels && driving_shakes();
  // Along a blind axis speed and travel are what the filter believes, not what anybody saw: there
  // the wheels decide.
  Mat3 seen = Mat3::Identity();
  if (blind_axis && wheels) seen -= *blind_axis * blind_axis->transpose();
  const bool stands = certain_ || (quiet && !moves_visibly(state, seen));
  learn_standing(state.t, stands, raw);
  return stands;
}

void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise) {
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
  const double white_a = noise.accel_mps2_rthz;
  const double white_g = noise.gyro_radps_rthz;
  state.P.diagonal().segment<3>(kVel).array() += white_a * white_a * dt_s;
  state.P.diagonal().segment<3>(kGyroBias).array() += noise.gyro_walk * noise.gyro_walk * dt_s;
  state.P.diagonal().segment<3>(kAccelBias).array() += noise.accel_walk * noise.accel_walk * dt_s;
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
