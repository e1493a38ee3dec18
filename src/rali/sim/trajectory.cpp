#include "rali/sim/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;
using geometry::Vec6;

Trajectory::Trajectory(std::vector<Control> controls, double spacing_s)
    : controls_(std::move(controls)), spacing_s_(spacing_s) {
  RALI_ASSERT(controls_.size() >= 4);
  RALI_ASSERT(spacing_s_ > 0.0);
  travelled_m_.push_back(0.0);
  for (std::size_t i = 1; i < controls_.size(); ++i) {
    const double step_m = (controls_[i] - controls_[i - 1]).head<2>().norm();
    travelled_m_.push_back(travelled_m_.back() + step_m);
  }
}

void Trajectory::append(const Control& control) {
  const double step_m = (control - controls_.back()).head<2>().norm();
  controls_.push_back(control);
  travelled_m_.push_back(travelled_m_.back() + step_m);
  if (jolts_) jolts_->extend_to(travelled_m_.back());
}

void Trajectory::add_jolts(const Jolts& jolts) {
  jolts_ = jolts;
  jolts_->extend_to(travelled_m_.back());
}

double Trajectory::duration_s() const {
  return static_cast<double>(controls_.size() - 3) * spacing_s_;
}

Trajectory::Place Trajectory::place(double t_s) const {
  const double spans = static_cast<double>(controls_.size() - 3);
  const double position = std::clamp(t_s / spacing_s_, 0.0, spans);
  const double first = std::min(std::floor(position), spans - 1.0);
  return {static_cast<std::size_t>(first), position - first};
}

double Trajectory::distance_m(double t_s) const {
  const auto [i, u] = place(t_s);
  return travelled_m_[i + 1] + u * (travelled_m_[i + 2] - travelled_m_[i + 1]);
}

double Trajectory::time_at_distance_s(double distance_m) const {
  const auto after = std::upper_bound(travelled_m_.begin(), travelled_m_.end(), distance_m);
  const auto k = static_cast<double>(after - travelled_m_.begin());
  if (after == travelled_m_.begin() || after == travelled_m_.end()) {
    return std::clamp((k - 1.0) * spacing_s_, 0.0, duration_s());
  }
  const double u = (distance_m - *(after - 1)) / (*after - *(after - 1));
  return std::clamp((k - 2.0 + u) * spacing_s_, 0.0, duration_s());
}

Vec6 Trajectory::jolt_at(double t_s) const {
  const auto [i, u] = place(t_s);
  const double step_m = travelled_m_[i + 2] - travelled_m_[i + 1];
  return jolts_->at(travelled_m_[i + 1] + u * step_m, step_m / spacing_s_);
}

geometry::SE3 Trajectory::pose_at(double t_s) const {
  geometry::SE3 T = smooth_pose_at(place(t_s));
  if (!jolts_) return T;
  const Vec6 jolt = jolt_at(t_s);
  T.p += T.R * jolt.head<3>();
  T.R = T.R * geometry::rotation_from_rpy(jolt[3], jolt[4], jolt[5]);
  return T;
}

Vec3 Trajectory::measured_jolt_mps2(double t_s, double sample_s) const {
  if (!jolts_ || jolts_->measured_ratio() <= 0.0) return Vec3::Zero();
  const auto offset = [&](double t) {
    return Vec3(smooth_pose_at(place(t)).R * jolt_at(t).head<3>());
  };
  return jolts_->measured_ratio() / (sample_s * sample_s) *
         (offset(t_s) - 2.0 * offset(t_s - sample_s) + offset(t_s - 2.0 * sample_s));
}

geometry::SE3 Trajectory::smooth_pose_at(const Place& place) const {
  const auto [i, u] = place;
  const double u2 = u * u;
  const double u3 = u2 * u;
  const Vec6 q =
      (controls_[i] * (1.0 - 3.0 * u + 3.0 * u2 - u3) +
       controls_[i + 1] * (4.0 - 6.0 * u2 + 3.0 * u3) +
       controls_[i + 2] * (1.0 + 3.0 * u + 3.0 * u2 - 3.0 * u3) + controls_[i + 3] * u3) /
      6.0;
  return {geometry::rotation_from_rpy(q[3], q[4], q[5]), q.head<3>()};
}

MotionState Trajectory::at(double t_s) const {
  // Callers that append controls query the end itself, up to rounding.
  if (t_s > duration_s() + spacing_s_) return {.T_world_body = pose_at(t_s)};
  const auto [i, u] = place(t_s);
  const Vec6& a = controls_[i];
  const Vec6& b = controls_[i + 1];
  const Vec6& c = controls_[i + 2];
  const Vec6& d = controls_[i + 3];
  const Vec6 rate = (-a * (1.0 - u) * (1.0 - u) + b * (3.0 * u * u - 4.0 * u) +
                     c * (1.0 + 2.0 * u - 3.0 * u * u) + d * u * u) /
                    (2.0 * spacing_s_);
  const Vec6 second = (a * (1.0 - u) + b * (3.0 * u - 2.0) + c * (1.0 - 3.0 * u) + d * u) /
                      (spacing_s_ * spacing_s_);
  MotionState state;
  state.T_world_body = smooth_pose_at({i, u});
  state.v_world_mps = rate.head<3>();
  state.a_world_mps2 = second.head<3>();

  // Body rates of R = Rz(yaw) Ry(pitch) Rx(roll) and their derivatives.
  const Vec3 rpy = geometry::rpy_from_rotation(state.T_world_body.R);
  if (jolts_) state.T_world_body = pose_at(t_s);
  const double sr = std::sin(rpy.x());
  const double cr = std::cos(rpy.x());
  const double sp = std::sin(rpy.y());
  const double cp = std::cos(rpy.y());
  const double dr = rate[3];
  const double dp = rate[4];
  const double dy = rate[5];
  state.omega_body_radps = {dr - dy * sp, dp * cr + dy * cp * sr, -dp * sr + dy * cp * cr};
  state.alpha_body_radps2 = {
      second[3] - second[5] * sp - dy * cp * dp,
      second[4] * cr - dp * sr * dr + second[5] * cp * sr - dy * sp * dp * sr + dy * cp * cr * dr,
      -second[4] * sr - dp * cr * dr + second[5] * cp * cr - dy * sp * dp * cr - dy * cp * sr * dr};
  return state;
}

double Trajectory::length_m() const {
  double sum = 0.0;
  for (std::size_t i = 1; i < controls_.size(); ++i) {
    sum += (controls_[i].head<3>() - controls_[i - 1].head<3>()).norm();
  }
  return sum;
}

}  // namespace rali::sim
