#include "rali/odometry/robust/standstill.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "rali/geometry/chi_square.hpp"
#include "rali/odometry/robust/lift_ride.hpp"
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
constexpr double kDrives_mps = 0.3;      // by the LiDAR, the vehicle drives
constexpr double kChanceToStart = 0.01;  // that one test rejects a window of standstill
constexpr double kTests = 3.0;           // quiet, turns, pushed
constexpr double kBlock_s = 0.1;         // stillness.hpp
constexpr double kLong_s = 15.0;

/// Noise alone reaches this value with less than this chance, or the value is invalid.
bool beyond(double chi2, int dof, double chance) {
  return !std::isfinite(chi2) || geometry::chi2_tail(chi2, dof) < chance;
}

}  // namespace

void StandstillDetector::learn(const imu::ImuStatistics& at_rest) { at_rest_ = at_rest; }

void StandstillDetector::stood_since(Time t, const geometry::SE3& T_odom_body) {
  recent_.assign(1, {t, T_odom_body});
  stands_since_ = t;
}

std::optional<imu::NoiseDensity> StandstillDetector::rest_density() const {
  if (!at_rest_ || at_rest_->period_s <= 0.0) return std::nullopt;
  const auto density = [this](const Vec3& sd) {
    return std::sqrt(sd.squaredNorm() / 3.0 * at_rest_->period_s);
  };
  return imu::NoiseDensity{density(at_rest_->gyro_sd_radps), density(at_rest_->accel_sd_mps2)};
}

/// Windows of consecutive scans overlap: treated as independent, this is an upper bound.
double StandstillDetector::chance(Time now) const {
  if (!stands_since_ || recent_.empty()) return kChanceToStart;
  const double between_s = std::clamp((now - recent_.back().t).s(), 0.0, constraints_.rest_after_s);
  return std::min(kChanceToStart, false_starts_per_hour_ * between_s / 3600.0 / kTests);
}

/// No more than the noise of the sensor, whose spread in a window varies by chance.
bool StandstillDetector::wheels_stand(const imu::ImuStatistics& raw) const {
  static constexpr double kSpreadMax = 1.3;
  if (!at_rest_ || raw.samples < 20) return false;
  const auto calm = [](const Vec3& now, const Vec3& rest) {
    return (now.array() < kSpreadMax * rest.array()).all();
  };
  return calm(raw.accel_sd_mps2, at_rest_->accel_sd_mps2) &&
         calm(raw.gyro_sd_radps, at_rest_->gyro_sd_radps);
}

bool StandstillDetector::calm(const FilterState& state, const InertialBuffer& imu) const {
  const Time begin = state.t - Duration::from_s(constraints_.rest_after_s);
  return state.v.norm() < kDrives_mps && wheels_stand(imu::statistics(imu.between(begin, state.t)));
}

/// Whether driving shakes the sensor well beyond its spread at standstill. Turns and changes of
/// speed do not count: on a smooth floor they are all that the sensor feels, and at constant speed
/// it feels nothing.
bool StandstillDetector::driving_shakes() const {
  constexpr double kFactor = 1.8;
  constexpr int kWindowsMin = 20;  // a start alone shakes differently
  return at_rest_ && driving_windows_ >= kWindowsMin &&
         (driving_accel_mps2_ > kFactor * at_rest_->accel_sd_mps2.norm() ||
          driving_gyro_radps_ > kFactor * at_rest_->gyro_sd_radps.norm());
}

void StandstillDetector::learn_driving(const FilterState& state,
                                       const std::vector<ImuSample>& window) {
  const double sigma2 = state.P.block<3, 3>(kVel, kVel).diagonal().maxCoeff();
  const bool drives =
      state.v.norm() > kDrives_mps && sigma2 < kSpeedSigmaMax_mps * kSpeedSigmaMax_mps;
  if (!drives || window.size() < 20) return;
  // A low quantile, followed slowly: a pose that drifts at standstill looks like smooth driving and
  // must not be learnt as such.
  constexpr double kQuantile = 0.2;
  constexpr double kStep = 0.01;
  ++driving_windows_;
  const double step = std::max(kStep, 1.0 / driving_windows_);
  const auto track = [step](double& low, double now) {
    low = low > 0.0 ? low * std::exp(step * (kQuantile - (now < low ? 1.0 : 0.0))) : now;
  };
  const Shaking now = shaking(window);
  track(driving_accel_mps2_, now.accel_mps2);
  track(driving_gyro_radps_, now.gyro_radps);
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
  const Time begin = state.t - Duration::from_s(constraints_.rest_after_s);
  return std::any_of(recent_.begin(), recent_.end(), [&](const Moment& m) {
    return m.t >= begin && (seen * (m.T.p - state.T_odom_body.p)).norm() > kTravelMax_m;
  });
}

double StandstillDetector::memory_s() const {
  return std::max(2.0 * constraints_.rest_after_s, at_rest_ ? 0.0 : kLong_s);
}

bool StandstillDetector::still_for_long(const FilterState& state, const InertialBuffer& imu,
                                        const Vec3& degenerate_axis) const {
  constexpr double kLateralMax_m = 0.02;
  constexpr double kTurnMax_rad = 0.004;
  const Time begin = state.t - Duration::from_s(kLong_s);
  if (recent_.front().t > begin) return false;
  const Mat3 seen = Mat3::Identity() - degenerate_axis * degenerate_axis.transpose();
  for (const Moment& m : recent_) {
    const geometry::Vec6 moved = geometry::boxminus(m.T, state.T_odom_body);
    if ((seen * (m.T.p - state.T_odom_body.p)).norm() > kLateralMax_m) return false;
    if (moved.head<3>().norm() > kTurnMax_rad) return false;
  }
  return is_only_noise(block_means(imu.between(begin, state.t)));
}

/// No shaking, or no more than the white noise of the sensor at standstill.
bool StandstillDetector::quiet(const imu::ImuStatistics& blocks, double chance) const {
  constexpr double kAxes = 6.0;
  if (blocks.samples < 4) return false;
  if (is_quiet(blocks, rest_)) return true;
  if (!at_rest_) return false;
  const double fraction = at_rest_->period_s / kBlock_s;  // of the variance that a block's mean has
  const auto noise = [&](double sd, double limit, double rest_sd) {
    const double chi2 = blocks.samples * sd * sd / (fraction * rest_sd * rest_sd);
    return sd < limit || !beyond(chi2, blocks.samples - 1, chance / kAxes);
  };
  bool all = true;
  for (int k = 0; k < 3; ++k) {
    all =
        all && noise(blocks.gyro_sd_radps[k], rest_.gyro_sd_max_radps, at_rest_->gyro_sd_radps[k]);
    all =
        all && noise(blocks.accel_sd_mps2[k], rest_.accel_sd_max_mps2, at_rest_->accel_sd_mps2[k]);
  }
  return all;
}

/// A starting vehicle squats slowly: below the spread of the blocks, but visible in their mean.
bool StandstillDetector::turns(const FilterState& state, const imu::ImuStatistics& blocks,
                               double gyro_radps_rthz, double chance) const {
  const Vec3 rate = blocks.gyro_mean_radps - state.gyro_bias_radps;
  const double white = gyro_radps_rthz * gyro_radps_rthz / constraints_.rest_after_s;
  const Mat3 S = state.P.block<3, 3>(kGyroBias, kGyroBias) + white * Mat3::Identity();
  return beyond(rate.dot(S.inverse() * rate), 3, chance);
}

bool StandstillDetector::update(const FilterState& state, const InertialBuffer& imu,
                                const std::optional<Vec3>& degenerate_axis,
                                double gyro_radps_rthz) {
  certain_ = false;
  const double by_chance = chance(state.t);
  recent_.push_back({state.t, state.T_odom_body});
  const Time begin = state.t - Duration::from_s(constraints_.rest_after_s);
  const Time oldest = state.t - Duration::from_s(at_rest_ ? constraints_.rest_after_s : kLong_s);
  while (recent_.size() > 2 && recent_[1].t <= oldest) recent_.pop_front();
  if (!constraints_.standstill || recent_.front().t > begin) return false;
  const std::vector<ImuSample> window = imu.between(begin, state.t);
  const imu::ImuStatistics raw = imu::statistics(window);
  const imu::ImuStatistics blocks = imu::statistics(block_means(window));
  learn_driving(state, window);
  const bool wheels = at_rest_ ? wheels_stand(raw)
                               : degenerate_axis && still_for_long(state, imu, *degenerate_axis);
  const bool still = quiet(blocks, by_chance) &&
                     !turns(state, blocks, gyro_radps_rthz, by_chance) &&
                     !pushed(state, blocks, raw, by_chance);
  // Along a degenerate axis speed and travel are not observed by the LiDAR: there wheels_stand()
  // decides.
  Mat3 seen = Mat3::Identity();
  if (degenerate_axis && wheels) seen -= *degenerate_axis * degenerate_axis->transpose();
  certain_ = still && wheels && driving_shakes();
  const bool stands = certain_ || (still && !moves_visibly(state, seen));
  learn_standing(state.t, stands, raw);
  return stands;
}

bool StandstillDetector::stands_in_lift(const FilterState& held, Time now,
                                        const InertialBuffer& imu, double gyro_radps_rthz) const {
  const double by_chance = chance(now);
  std::vector<ImuSample> window =
      imu.between(now - Duration::from_s(constraints_.rest_after_s), now);
  remove_lift(held, window);
  const imu::ImuStatistics blocks = imu::statistics(block_means(window));
  return quiet(blocks, by_chance) && !turns(held, blocks, gyro_radps_rthz, by_chance) &&
         !pushed(held, blocks, imu::statistics(window), by_chance);
}

namespace {

using Rows3 = Eigen::Matrix<double, 3, kStateDim>;

/// Force in odom that is unexplained if the vehicle is at standstill.
Vec3 unexplained(const FilterState& state, const Vec3& accel_mps2) {
  return state.T_odom_body.R * (accel_mps2 - state.accel_bias_mps2) + state.g_odom_mps2;
}

Rows3 unexplained_rows(const FilterState& state, const Vec3& accel_mps2) {
  const Mat3& R = state.T_odom_body.R;
  Rows3 H = Rows3::Zero();
  H.block<3, 3>(0, kTheta) = -R * geometry::skew(accel_mps2 - state.accel_bias_mps2);
  H.block<3, 3>(0, kAccelBias) = -R;
  H.block<3, 2>(0, kGravity) =
      -geometry::skew(state.g_odom_mps2) * gravity_basis(state.g_odom_mps2);
  return H;
}

/// Updates biases and gravity; the pose is considered, not estimated (Schmidt 1966). It stays, and
/// the correlation lets gravity follow when the LiDAR corrects the pose.
void teach(FilterState& state, const Rows3& H, const Vec3& residual, double variance) {
  const Eigen::Matrix<double, kStateDim, 3> PHt = state.P * H.transpose();
  const Mat3 S = H * PHt + variance * Mat3::Identity();
  Eigen::Matrix<double, kStateDim, 3> K = PHt * S.inverse();
  K.topRows<kGyroBias>().setZero();
  const StateCov A = StateCov::Identity() - K * H;
  state.P = A * state.P * A.transpose() + variance * K * K.transpose();
  state.P = 0.5 * (state.P + state.P.transpose()).eval();
  if (state.augmented.size() > 0) state.P_augmented = (A * state.P_augmented).eval();
  add_error(state, K * residual);
}

}  // namespace

/// A smooth start shows first as a force on the sensor.
bool StandstillDetector::pushed(const FilterState& state, const imu::ImuStatistics& blocks,
                                const imu::ImuStatistics& raw, double chance) const {
  constexpr double kSway_mps2 = 0.03;  // 3 mrad: a person gets in, the ground yields
  const imu::ImuStatistics& sensor = at_rest_ ? *at_rest_ : raw;
  const double white =
      sensor.accel_sd_mps2.squaredNorm() / 3.0 * sensor.period_s / constraints_.rest_after_s;
  const Eigen::Vector2d force = unexplained(state, blocks.accel_mean_mps2).head<2>();
  const Rows3 H = unexplained_rows(state, blocks.accel_mean_mps2);
  const Mat3 P = H * state.P * H.transpose();
  const Eigen::Matrix2d S =
      P.topLeftCorner<2, 2>() + (white + kSway_mps2 * kSway_mps2) * Eigen::Matrix2d::Identity();
  return beyond(force.dot(S.inverse() * force), 2, chance);
}

void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise) {
  constexpr double kSway_mps2 = 0.002, kSway_radps = 1e-5;  // of a vehicle on its springs
  const double dt_s = (t_end - state.t).s();
  if (dt_s <= 0.0) return;
  const imu::ImuStatistics stats = imu::statistics(buffer.between(state.t + Duration{1}, t_end));
  const ImuSample now = buffer.at(t_end);
  const Vec3 gyro = stats.samples > 0 ? stats.gyro_mean_radps : now.gyro_radps;
  const Vec3 accel = stats.samples > 0 ? stats.accel_mean_mps2 : now.accel_mps2;
  state.P.diagonal().segment<3>(kGyroBias).array() += noise.gyro_walk * noise.gyro_walk * dt_s;
  state.P.diagonal().segment<3>(kAccelBias).array() += noise.accel_walk * noise.accel_walk * dt_s;
  state.t = t_end;

  constexpr double kZeroSpeedSigma_mps = 0.01;
  state.v.setZero();
  decorrelate(state, kVel, 3);
  state.P.diagonal().segment<3>(kVel).setConstant(kZeroSpeedSigma_mps * kZeroSpeedSigma_mps);

  const double white_a = noise.accel_mps2_rthz, white_g = noise.gyro_radps_rthz;
  teach(state, unexplained_rows(state, accel), -unexplained(state, accel),
        white_a * white_a / dt_s + kSway_mps2 * kSway_mps2);
  Rows3 H = Rows3::Zero();
  H.block<3, 3>(0, kGyroBias).setIdentity();
  teach(state, H, gyro - state.gyro_bias_radps,
        white_g * white_g / dt_s + kSway_radps * kSway_radps);
}

}  // namespace rali::odometry
