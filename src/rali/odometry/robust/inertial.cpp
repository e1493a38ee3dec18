#include "rali/odometry/robust/inertial.hpp"

#include <algorithm>

#include "rali/base/assert.hpp"

namespace rali::odometry {

using geometry::Vec3;
using sensor::ImuSample;

namespace {

// A jolt or an impact: the accelerometer then measures more than rigid motion (algorithms 2.6).
constexpr double kJoltAccel_mps2 = 3.0;
constexpr double kJoltFactor = 3.0;

// Beyond this many nominal intervals a gap is integrated with growing doubt.
constexpr double kStepMax_s = 0.02;

bool earlier(const ImuSample& a, Time t) { return a.t < t; }

}  // namespace

void InertialBuffer::add(const ImuSample& sample) {
  // A recording whose LiDAR stays away must not fill the memory.
  constexpr std::size_t kSamplesMax = 100'000;
  if (samples_.size() >= kSamplesMax) samples_.pop_front();
  samples_.push_back(sample);
}

void InertialBuffer::drop_before(Time t) {
  while (samples_.size() >= 2 && samples_[1].t <= t) samples_.pop_front();
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

void propagate_over(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ImuNoiseSettings& noise, std::vector<TimedPose>& poses) {
  ProcessNoise q;
  q.gyro_walk = noise.gyro_walk_radps2_rthz;
  q.accel_walk = noise.accel_walk_mps3_rthz;
  std::vector<Time> stops;
  for (const ImuSample& s : buffer.between(state.t + Duration{1}, t_end)) stops.push_back(s.t);
  if (stops.empty() || stops.back() < t_end) stops.push_back(t_end);
  ImuSample a = buffer.at(state.t);
  for (const Time t : stops) {
    const ImuSample b = buffer.at(t);
    const double dt_s = (t - state.t).s();
    const Vec3 gyro = 0.5 * (a.gyro_radps + b.gyro_radps);
    const Vec3 accel = 0.5 * (a.accel_mps2 + b.accel_mps2);
    const double excess = std::abs(accel.norm() - state.g_odom_mps2.norm());
    const double jolt = excess > kJoltAccel_mps2 ? kJoltFactor : 1.0;
    const double gap = std::max(1.0, dt_s / kStepMax_s);
    q.gyro_radps_rthz = noise.gyro_radps_rthz * noise.vibration_factor * gap;
    q.accel_mps2_rthz = noise.accel_mps2_rthz * noise.vibration_factor * jolt * gap;
    propagate_inertial(state, gyro, accel, dt_s, q);
    state.t = t;
    poses.push_back({t, state.T_odom_body});
    a = b;
  }
}

}  // namespace rali::odometry
