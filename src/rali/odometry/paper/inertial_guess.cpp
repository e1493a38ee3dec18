#include "rali/odometry/paper/inertial_guess.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace rali::odometry::paper {

using geometry::SE3;
using geometry::Vec3;
using sensor::ImuSample;

namespace {

constexpr double kGravityMps2 = 9.81;
constexpr double kStartWindowS = 1.0;           // algorithms.md 1.4
constexpr std::int64_t kBlockNs = 100'000'000;  // averages out white noise, but not driving
constexpr double kMotionKnownS = 0.45;          // data of this length are enough to detect motion
constexpr double kRestTravelM = 0.02;           // by the LiDAR, over one second
constexpr double kRestTurnRad = 0.3 * std::numbers::pi / 180.0;
constexpr double kGyroBiasMaxRadps = 0.05;  // more is a broken sensor or wrong units
constexpr double kAccelBiasMaxMps2 = 0.5;
constexpr double kCoveredMin = 0.5;           // less of an interval with samples: no IMU
constexpr double kSampleGapS = 0.1;           // with less of an interval covered: no IMU
constexpr std::size_t kSamplesMax = 100'000;  // 100 s at 1 kHz: older ones are dropped

double seconds_of(const std::vector<ImuSample>& samples) {
  return samples.size() < 2 ? 0.0 : seconds_between(samples.front().t, samples.back().t);
}

}  // namespace

InertialGuess::InertialGuess(const ImuNoiseSettings& noise, const SE3& T_body_imu,
                             double velocity_gain, double bias_gain)
    : T_body_imu_(T_body_imu),
      velocity_gain_(velocity_gain),
      bias_gain_(bias_gain),
      pre_({}, {noise.gyro_radps_rthz * noise.vibration_factor,
                noise.accel_mps2_rthz * noise.vibration_factor}),
      pre_keyframe_(pre_),
      graph_(noise) {
  reset(Time{}, {});
}

void InertialGuess::add(const ImuSample& sample) {
  if (!sample.gyro_radps.allFinite() || !sample.accel_mps2.allFinite()) return;
  if (!samples_.empty() && sample.t <= samples_.back().t) return;
  samples_.push_back(sample);
  samples_.back().accel_mps2 *= accel_scale_;
  if (samples_.size() > kSamplesMax) samples_.pop_front();
}

std::vector<ImuSample> InertialGuess::between(Time begin, Time end) const {
  std::vector<ImuSample> out;
  for (const ImuSample& s : samples_) {
    if (s.t >= begin && s.t <= end) out.push_back(s);
  }
  return out;
}

std::vector<ImuSample> InertialGuess::block_means(Time begin, Time end) const {
  std::vector<ImuSample> out;
  double n = 0.0;
  for (const ImuSample& s : between(begin, end)) {
    if (out.empty() || s.t.ns - out.back().t.ns >= kBlockNs) {
      out.push_back({s.t, Vec3::Zero(), Vec3::Zero()});
      n = 0.0;
    }
    n += 1.0;
    out.back().gyro_radps += (s.gyro_radps - out.back().gyro_radps) / n;
    out.back().accel_mps2 += (s.accel_mps2 - out.back().accel_mps2) / n;
  }
  return out;
}

InertialGuess::Start InertialGuess::try_start(Time t, FindingList& findings) {
  if (samples_.empty()) return Start::kWait;
  const Time begin = t - Duration::from_s(kStartWindowS);
  const std::vector<ImuSample> window = between(begin, t);
  const double seen_s = seconds_of(window);
  if (seen_s < kMotionKnownS) return Start::kWait;
  scale_units(findings);
  const std::vector<ImuSample> blocks = block_means(begin, t);
  imu::ImuStatistics stats = imu::statistics(blocks);
  stats.samples *= 10;  // is_rest counts samples; a block has ten or more
  const bool rest = imu::is_rest(stats, imu::RestSettings{});
  if (rest && seen_s < 0.9 * kStartWindowS) return Start::kWait;
  set_attitude(between(begin, t), rest);
  reset(t, T_odom_body());
  graph_.reset(state_.R_odom_imu.row(2).transpose(), rest);
  return rest ? Start::kAtRest : Start::kInMotion;
}

// A sensor that reports g instead of m/s^2 is recognised within a second: no vehicle falls at 0.9
// g.
void InertialGuess::scale_units(FindingList& findings) {
  if (units_known_) return;
  units_known_ = true;
  Vec3 mean = Vec3::Zero();
  for (const ImuSample& s : samples_) mean += s.accel_mps2 / static_cast<double>(samples_.size());
  const double norm = mean.norm();
  if (norm > 0.9 && norm < 1.1) {
    accel_scale_ = kGravityMps2;
    for (ImuSample& s : samples_) s.accel_mps2 *= accel_scale_;
  } else if (std::abs(norm - kGravityMps2) < 0.3) {
    return;
  }
  Finding f;
  f.id = accel_scale_ > 1.0 ? "odometry.accel_in_g" : "odometry.accel_norm";
  f.t = samples_.back().t;
  f.value = norm;
  f.limit = kGravityMps2;
  f.text =
      accel_scale_ > 1.0
          ? fmt::format("mean acceleration at the start is {:.3f}: taken as g, times 9.81", norm)
          : fmt::format("mean acceleration at the start is {:.2f} m/s2 instead of 9.81", norm);
  f.effect = accel_scale_ > 1.0 ? "" : "level and speed may be wrong";
  f.remedy = accel_scale_ > 1.0 ? "" : "Start at rest, or check the accelerometer's unit.";
  findings.push_back(f);
}

// Test T5 of the design: the smallest rotation that turns the mean force up. At standstill the
// gyro's mean is its bias. The accelerometer's bias is observable only along gravity; its other
// components are indistinguishable from a tilt.
void InertialGuess::set_attitude(const std::vector<ImuSample>& samples, bool at_rest) {
  const imu::ImuStatistics mean = imu::statistics(samples);
  const double norm = mean.accel_mean_mps2.norm();
  const geometry::Mat3 R_odom_body = norm > 1e-3 ? imu::level(T_body_imu_.R * mean.accel_mean_mps2)
                                                 : geometry::Mat3(geometry::Mat3::Identity());
  state_ = {};
  state_.R_odom_imu = R_odom_body * T_body_imu_.R;
  state_.p_odom_m = R_odom_body * T_body_imu_.p;
  bias_ = {};
  if (at_rest) {
    bias_.gyro_radps = mean.gyro_mean_radps;
    bias_.accel_mps2 = mean.accel_mean_mps2 * (1.0 - kGravityMps2 / norm);
  }
}

void InertialGuess::predict(Time t_end, std::vector<TimedPose>& poses) {
  poses.assign(1, {t_, T_odom_body()});
  pre_.reset(bias_);
  const double span_s = seconds_between(t_, t_end);
  predicted_s_ = std::max(0.0, span_s);
  if (!(span_s > 0.0)) return;
  const imu::InertialState before = state_;
  const double covered_s = integrate_to(t_end, poses);
  inertial_ = covered_s >= kCoveredMin * span_s;
  if (inertial_) {
    graph_.advance(pre_, before, state_, kGravityOdom, bias_);
  } else {
    state_ = before;
    poses.resize(1);
    pre_.reset(bias_);
    coast_to(t_end);
    graph_.advance_degenerate(span_s);
    poses.push_back({t_end, T_odom_body()});
  }
  t_ = t_end;
  delta_rotation_ = last_registered_.R_odom_imu.transpose() * state_.R_odom_imu;
}

// Samples are averaged over each interval instead of held, which would lag by half an interval.
double InertialGuess::integrate_to(Time t_end, std::vector<TimedPose>& poses) {
  const Time t_start = t_;
  const imu::InertialState start = state_;
  double covered_s = 0.0;
  if (samples_.empty() || samples_.back().t < t_start) return 0.0;
  Time from = t_start;
  ImuSample left = at(from);
  const auto add_until = [&](Time to, const ImuSample& right) {
    const double dt_s = seconds_between(from, to);
    if (pre_.add(0.5 * (left.gyro_radps + right.gyro_radps),
                 0.5 * (left.accel_mps2 + right.accel_mps2), dt_s)) {
      if (dt_s <= kSampleGapS) covered_s += dt_s;
      keyframe_covered_ &= dt_s <= kSampleGapS &&
                           pre_keyframe_.add(0.5 * (left.gyro_radps + right.gyro_radps),
                                             0.5 * (left.accel_mps2 + right.accel_mps2), dt_s);
      state_ = pre_.predict(start, kGravityOdom, bias_);
      rate_imu_radps_ = right.gyro_radps - bias_.gyro_radps;
      poses.push_back({to, T_odom_body()});
    }
    from = to;
    left = right;
  };
  for (const ImuSample& s : samples_) {
    if (s.t > from && s.t < t_end) add_until(s.t, s);
  }
  if (from < t_end) add_until(t_end, at(t_end));
  return covered_s;
}

// Linear between samples, held beyond the ends.
ImuSample InertialGuess::at(Time t) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t,
                                      [](const ImuSample& s, Time time) { return s.t < time; });
  if (after == samples_.begin()) return samples_.front();
  if (after == samples_.end()) return samples_.back();
  const ImuSample& a = *(after - 1);
  const ImuSample& b = *after;
  const double s = seconds_between(a.t, t) / seconds_between(a.t, b.t);
  return {t, a.gyro_radps + s * (b.gyro_radps - a.gyro_radps),
          a.accel_mps2 + s * (b.accel_mps2 - a.accel_mps2)};
}

void InertialGuess::coast_to(Time t_end) {
  keyframe_covered_ = false;
  const double dt_s = seconds_between(t_, t_end);
  state_.p_odom_m += state_.v_odom_mps * dt_s;
  state_.R_odom_imu =
      geometry::so3_normalised(state_.R_odom_imu * geometry::so3_exp(rate_imu_radps_ * dt_s));
}

void InertialGuess::correct(const SE3& T_odom_body) {
  const SE3 T_odom_imu = T_odom_body * T_body_imu_;
  const double D = seconds_between(t_last_registered_, t_);
  if (D > 0.0) {
    const Vec3 mean_v = (T_odom_imu.p - last_registered_.p_odom_m) / D;
    Vec3 v = mean_v;
    // After a scan that was only predicted, the deltas cover just the last part of D.
    const bool deltas_cover = std::abs(pre_.duration_s() - D) < 1e-6;
    if (inertial_ && deltas_cover) {
      // r_p = 0 solved for v_i, then r_v = 0 for v_j: the finite difference is the velocity in the
      // middle of the interval, the deltas propagate it to the end.
      v += kGravityOdom * (0.5 * D) +
           last_registered_.R_odom_imu *
               (pre_.delta_velocity_mps(bias_) - pre_.delta_position_m(bias_) / D);
      const Vec3 innovation_mps = v - state_.v_odom_mps;
      track_biases(innovation_mps, T_odom_imu.R, D);
      state_.v_odom_mps += velocity_gain_ * innovation_mps;
    } else if (!inertial_) {
      state_.v_odom_mps = v;
      rate_imu_radps_ =
          geometry::so3_log(last_registered_.R_odom_imu.transpose() * T_odom_imu.R) / D;
    }
  }
  state_.R_odom_imu = T_odom_imu.R;
  state_.p_odom_m = T_odom_imu.p;
  remember_registered();
  if (inertial_) learn_gyro_bias();
  drop_used();
}

void InertialGuess::remember_registered() {
  last_registered_ = state_;
  t_last_registered_ = t_;
  past_.push_back({t_, {state_.R_odom_imu, state_.p_odom_m}});
  while (seconds_between(past_.front().t, t_) > 1.5 * kStartWindowS) past_.pop_front();
}

// From deviations of the IMU's pose to those of the body's, boxplus order.
geometry::Mat6 InertialGuess::d_body_d_imu() const {
  geometry::Mat6 G = geometry::Mat6::Identity();
  G.topLeftCorner<3, 3>() = T_body_imu_.R;
  G.bottomLeftCorner<3, 3>() = -state_.R_odom_imu * geometry::skew(T_body_imu_.inverse().p);
  return G;
}

void InertialGuess::fuse(const geometry::Mat6& information, const geometry::Vec6& pull) {
  const geometry::Mat6 G = d_body_d_imu();
  graph_.add_registration(G.transpose() * information * G, G.transpose() * pull, state_, bias_);
  remember_registered();
  drop_used();
}

void InertialGuess::fuse_covariance(const geometry::Mat6& information) {
  const geometry::Mat6 G = d_body_d_imu();
  imu::InertialState state = state_;
  imu::InertialBias bias = bias_;
  graph_.add_registration(G.transpose() * information * G, geometry::Vec6::Zero(), state, bias);
}

void InertialGuess::start_standstill() { graph_.start_standstill(); }

void InertialGuess::stay(const SE3& T_odom_body) {
  const SE3 T_odom_imu = T_odom_body * T_body_imu_;
  state_ = {T_odom_imu.R, T_odom_imu.p, Vec3::Zero()};
  graph_.stay();
  keyframe_covered_ = false;  // deltas over minutes of standstill do not help the following drive
  remember_registered();
  learn_gyro_bias();
  drop_used();
}

void InertialGuess::know_along(const KnownAlong& known) {
  const Vec3 p_odom_body = T_odom_body().p;
  graph_.know_along(known.e_odom, known.shift_m, known.sigma_m * known.sigma_m, state_, bias_);
  state_.p_odom_m += p_odom_body - T_odom_body().p;  // the body stays, the IMU turns about it
  cut_biases();
  last_registered_ = state_;
}

void InertialGuess::move(const SE3& T_new_old) {
  const auto move_pose = [&T_new_old](geometry::Mat3& R, Vec3& p) {
    R = geometry::so3_normalised(T_new_old.R * R);
    p = T_new_old * p;
  };
  for (imu::InertialState* state : {&state_, &last_registered_}) {
    move_pose(state->R_odom_imu, state->p_odom_m);
    state->v_odom_mps = T_new_old.R * state->v_odom_mps;
  }
  // Otherwise the shift would look like motion to learn_gyro_bias().
  for (PastPose& past : past_) move_pose(past.T_odom_imu.R, past.T_odom_imu.p);
}

void InertialGuess::start_keyframe() {
  pre_keyframe_.reset(bias_);
  keyframe_covered_ = true;
}

void InertialGuess::set_motion(const KeyframeMotion& motion) {
  if (!motion.v_odom_imu_mps.allFinite() || !motion.bias.gyro_radps.allFinite() ||
      !motion.bias.accel_mps2.allFinite()) {
    return;
  }
  state_.v_odom_mps = motion.v_odom_imu_mps;
  last_registered_.v_odom_mps = motion.v_odom_imu_mps;
  bias_ = motion.bias;
  cut_biases();
}

geometry::Mat6 InertialGuess::covariance() const {
  const geometry::Mat6 G = d_body_d_imu();
  const geometry::Mat6 C = G * graph_.pose_covariance() * G.transpose();
  return 0.5 * (C + C.transpose());
}

// The paper leaves biases to its pose graph. Here a first-order observer applies a small fraction
// of each scan's innovation: without it a tilt of 0.2 deg is 2 m/s after a minute along a
// degenerate direction. Along such directions the innovation is nearly zero, so nothing is learnt
// there.
void InertialGuess::track_biases(const Vec3& velocity_innovation_mps,
                                 const geometry::Mat3& R_odom_imu, double dt_s) {
  const Vec3 turn = geometry::so3_log(state_.R_odom_imu.transpose() * R_odom_imu);
  bias_.gyro_radps -= bias_gain_ * turn / dt_s;
  bias_.accel_mps2 -= bias_gain_ * (R_odom_imu.transpose() * velocity_innovation_mps) / dt_s;
  cut_biases();
}

void InertialGuess::cut_biases() {
  const double gyro = bias_.gyro_radps.norm();
  const double accel = bias_.accel_mps2.norm();
  if (gyro > kGyroBiasMaxRadps) bias_.gyro_radps *= kGyroBiasMaxRadps / gyro;
  if (accel > kAccelBiasMaxMps2) bias_.accel_mps2 *= kAccelBiasMaxMps2 / accel;
}

// If both IMU and LiDAR show standstill, the gyro's mean is its bias. Both are needed: slow even
// driving looks like rest to the IMU, and motion along a degenerate direction to the LiDAR.
void InertialGuess::learn_gyro_bias() {
  if (seconds_between(past_.front().t, t_) < kStartWindowS) return;
  for (const PastPose& p : past_) {
    if ((p.T_odom_imu.p - state_.p_odom_m).norm() > kRestTravelM) return;
    if (geometry::so3_log(p.T_odom_imu.R.transpose() * state_.R_odom_imu).norm() > kRestTurnRad) {
      return;
    }
  }
  const Time begin = t_ - Duration::from_s(kStartWindowS);
  imu::ImuStatistics stats = imu::statistics(block_means(begin, t_));
  stats.samples *= 10;
  if (imu::is_rest(stats, imu::RestSettings{})) bias_.gyro_radps = stats.gyro_mean_radps;
}

void InertialGuess::drop_used() {
  const Time oldest = t_ - Duration::from_s(1.5 * kStartWindowS);
  while (samples_.size() > 1 && samples_[1].t < oldest) samples_.pop_front();
}

void InertialGuess::reset(Time t, const SE3& T_odom_body) {
  const SE3 T_odom_imu = T_odom_body * T_body_imu_;
  t_ = t;
  state_ = {T_odom_imu.R, T_odom_imu.p, Vec3::Zero()};
  rate_imu_radps_.setZero();
  last_registered_ = state_;
  t_last_registered_ = t;
  delta_rotation_.setIdentity();
  keyframe_covered_ = false;
  graph_.reset(state_.R_odom_imu.row(2).transpose(), false);
  past_.clear();
}

SE3 InertialGuess::T_odom_body() const {
  return SE3{state_.R_odom_imu, state_.p_odom_m} * T_body_imu_.inverse();
}

// The IMU is offset from the body's origin: v_body = v_imu + w x (from IMU to body).
Vec3 InertialGuess::v_odom_body_mps() const {
  const Vec3 p_imu_body = T_body_imu_.inverse().p;
  return state_.v_odom_mps + state_.R_odom_imu * (geometry::skew(rate_imu_radps_) * p_imu_body);
}

}  // namespace rali::odometry::paper
