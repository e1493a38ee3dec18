#include "rali/odometry/robust/inertial.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"
#include "rali/imu/kinematics.hpp"

namespace rali::odometry {

using geometry::Vec3;
using sensor::ImuSample;

namespace {

// A jolt or an impact happens within a sample: if two samples differ by so much more than vibration
// explains, the motion between them is unknown.
constexpr double kJoltAccel_mps2 = 3.0;
constexpr double kJoltGyro_radps = 1.0;

// A gap beyond this many nominal intervals is integrated with growing noise.
constexpr double kStepMax_s = 0.02;

bool earlier(const ImuSample& a, Time t) { return a.t < t; }

}  // namespace

void InertialBuffer::add(const ImuSample& sample) {
  // A recording whose LiDAR data stop must not fill the memory.
  constexpr std::size_t kSamplesMax = 100'000;
  if (samples_.size() >= kSamplesMax) samples_.pop_front();
  watch_clipping(sample);
  samples_.push_back(sample);
}

/// Exactly the largest value so far, three times in a row: noisy sensors never repeat it by chance.
/// An axis that repeats values all the time has no noise, or few bits, so its repeats prove
/// nothing.
void InertialBuffer::watch_clipping(const ImuSample& sample) {
  constexpr double kGyroMin_radps = 0.2;
  constexpr double kAccelMin_mps2 = 10.5;
  constexpr int kInARow = 3;
  constexpr double kRepeatsMax = 0.5;
  const auto is_clipped = [&](Axis& axis, double value, double before, double minimum) {
    const double size = std::abs(value);
    const bool again = !samples_.empty() && value == before;
    axis.in_a_row = again ? axis.in_a_row + 1 : 1;
    const bool at_most = size > minimum && size >= axis.maximum;
    if (!at_most || !again) axis.repeats += 0.01 * ((again ? 1.0 : 0.0) - axis.repeats);
    axis.maximum = std::max(axis.maximum, size);
    return at_most && axis.in_a_row >= kInARow && axis.repeats < kRepeatsMax;
  };
  const ImuSample& before = samples_.empty() ? sample : samples_.back();
  ClippedAxes clipped;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    clipped.gyro[i] =
        is_clipped(axes_[i], sample.gyro_radps[k], before.gyro_radps[k], kGyroMin_radps);
    clipped.accel[i] =
        is_clipped(axes_[i + 3], sample.accel_mps2[k], before.accel_mps2[k], kAccelMin_mps2);
  }
  if (clipped.any()) clipped_.emplace_back(sample.t, clipped);
}

ClippedAxes InertialBuffer::clipped(Time begin, Time end) const {
  ClippedAxes out;
  for (const auto& [t, axes] : clipped_) {
    if (t < begin) continue;
    if (t > end) break;
    for (std::size_t i = 0; i < 3; ++i) {
      out.gyro[i] = out.gyro[i] || axes.gyro[i];
      out.accel[i] = out.accel[i] || axes.accel[i];
    }
  }
  return out;
}

void InertialBuffer::drop_before(Time t) {
  while (samples_.size() >= 2 && samples_[1].t <= t) samples_.pop_front();
  while (!clipped_.empty() && clipped_.front().first < t) clipped_.pop_front();
}

ImuSample InertialBuffer::at(Time t) const {
  RALI_ASSERT(!samples_.empty());
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t, earlier);
  if (after == samples_.begin()) return samples_.front();
  if (after == samples_.end()) return samples_.back();
  const ImuSample& b = *after;
  const ImuSample& a = *(after - 1);
  const double span = (b.t - a.t).s();
  const double s = span > 0.0 ? (t - a.t).s() / span : 1.0;
  return {t, a.gyro_radps + s * (b.gyro_radps - a.gyro_radps),
          a.accel_mps2 + s * (b.accel_mps2 - a.accel_mps2)};
}

std::vector<ImuSample> InertialBuffer::between(Time begin, Time end) const {
  std::vector<ImuSample> out;
  auto it = std::lower_bound(samples_.begin(), samples_.end(), begin, earlier);
  for (; it != samples_.end() && it->t <= end; ++it) out.push_back(*it);
  return out;
}

double InertialBuffer::longest_gap_s(Time begin, Time end) const {
  double longest = 0.0;
  Time last = begin;
  auto it = std::lower_bound(samples_.begin(), samples_.end(), begin, earlier);
  for (; it != samples_.end() && it->t <= end; ++it) {
    longest = std::max(longest, (it->t - last).s());
    last = it->t;
  }
  return std::max(longest, (end - last).s());
}

namespace {

/// The times of the samples between two times, the last one included.
std::vector<Time> stops_between(const InertialBuffer& buffer, Time begin, Time end) {
  std::vector<Time> stops;
  for (const ImuSample& s : buffer.between(begin + Duration{1}, end)) stops.push_back(s.t);
  if (stops.empty() || stops.back() < end) stops.push_back(end);
  return stops;
}

/// Process noise for the motion that a sensor at the limit of its range does not measure: about as
/// much again as it measures. The other axes are unaffected: a gyro that clips during a turn on the
/// spot must not add noise to the translation.
void add_clipped(FilterState& state, const ClippedAxes& clipped, double dt_s) {
  constexpr double kGyro_radps_rthz = 0.3;
  constexpr double kAccel_mps2_rthz = 1.0;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (clipped.gyro[i]) {
      state.P(kTheta + k, kTheta + k) += kGyro_radps_rthz * kGyro_radps_rthz * dt_s;
    }
    if (!clipped.accel[i]) continue;
    const Vec3 axis = state.T_odom_body.R.col(k);
    state.P.block<3, 3>(kVel, kVel) +=
        kAccel_mps2_rthz * kAccel_mps2_rthz * dt_s * axis * axis.transpose();
  }
}

}  // namespace

void propagate_over(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise, std::vector<TimedPose>& poses) {
  ProcessNoise q = noise;
  const ClippedAxes clipped = buffer.clipped(state.t, t_end);
  ImuSample a = buffer.at(state.t);
  for (const Time t : stops_between(buffer, state.t, t_end)) {
    const ImuSample b = buffer.at(t);
    const double dt_s = (t - state.t).s();
    const Vec3 gyro = 0.5 * (a.gyro_radps + b.gyro_radps);
    const Vec3 accel = 0.5 * (a.accel_mps2 + b.accel_mps2);
    const double gap = std::max(1.0, dt_s / kStepMax_s);
    // Half of the difference over the step, as a noise density.
    const double root_dt = 0.5 * std::sqrt(std::max(0.0, dt_s));
    const double turn = std::max(0.0, (b.gyro_radps - a.gyro_radps).norm() - kJoltGyro_radps);
    const double jolt = std::max(0.0, (b.accel_mps2 - a.accel_mps2).norm() - kJoltAccel_mps2);
    q.gyro_radps_rthz = std::hypot(noise.gyro_radps_rthz * gap, turn * root_dt);
    q.accel_mps2_rthz = std::hypot(noise.accel_mps2_rthz * gap, jolt * root_dt);
    propagate_inertial(state, gyro, accel, dt_s, q);
    if (clipped.any()) add_clipped(state, clipped, dt_s);
    state.t = t;
    poses.push_back({t, state.T_odom_body});
    a = b;
  }
}

InertialIntegral integrate_from(const FilterState& state, const InertialBuffer& buffer,
                                Time t_end) {
  imu::KinematicState k{{state.T_odom_body.R, Vec3::Zero()}, Vec3::Zero()};
  ImuSample a = buffer.at(state.t);
  Time t = state.t;
  for (const Time stop : stops_between(buffer, state.t, t_end)) {
    const ImuSample b = buffer.at(stop);
    imu::integrate(k, 0.5 * (a.gyro_radps + b.gyro_radps) - state.gyro_bias_radps,
                   0.5 * (a.accel_mps2 + b.accel_mps2) - state.accel_bias_mps2, state.g_odom_mps2,
                   (stop - t).s());
    t = stop;
    a = b;
  }
  return {k.v_odom_mps, k.T_odom_body.p, state.T_odom_body.R.transpose() * k.T_odom_body.R};
}

}  // namespace rali::odometry
