#include "rali/odometry/robust/lift_ride.hpp"

#include <algorithm>
#include <cmath>

namespace rali::odometry {

using geometry::Vec3;
using sensor::ImuSample;

namespace {

constexpr double kRest_s = 1.0;
/// Fraction of a speed: errors of scale of the accelerometer.
constexpr double kScale = 0.01;

Vec3 up_in_body(const FilterState& held) {
  return -(held.T_odom_body.R.transpose() * held.g_odom_mps2).normalized();
}

/// Bias minus gravity, in the body.
Vec3 at_rest_mps2(const FilterState& held) {
  return held.accel_bias_mps2 - held.T_odom_body.R.transpose() * held.g_odom_mps2;
}

}  // namespace

void LiftRide::stand(Time t) {
  *this = {};
  begin_ = now_.t = t;
}

void LiftRide::add(std::span<const ImuSample> samples, const FilterState& held,
                   double white_mps2_rthz) {
  // A LiDAR at standstill overlooks 0.03 m; a person who gets in lowers the springs by as much.
  constexpr double kHeight_m = 0.06;
  // Within a second. Lifts gain 0.3 to 1 m/s; a bias learnt while driving is wrong by less.
  constexpr double kSpeed_mps = 0.2;
  constexpr double kBroken_s = 0.5;             // without samples the speed is lost
  constexpr double kForceSigmaMin_mps2 = 0.01;  // what a sensor warming up changes by
  if ((held.t - now_.t).s() > kBroken_s) stand(held.t);
  white_mps2_rthz_ = white_mps2_rthz;
  force_sigma_mps2_ = std::max(kForceSigmaMin_mps2, force_sigma_mps2(held));
  const Vec3 up = up_in_body(held);
  const Vec3 rest = at_rest_mps2(held);
  for (const ImuSample& sample : samples) {
    if (sample.t <= now_.t) continue;
    const double dt_s = (sample.t - now_.t).s();
    const double force = up.dot(sample.accel_mps2 - rest);
    const double before = now_.speed_mps;
    now_ = {sample.t, before + 0.5 * dt_s * (force + force_mps2_)};
    height_m_ += 0.5 * dt_s * (before + now_.speed_mps);
    force_mps2_ = force;
    fastest_mps_ = std::max(fastest_mps_, std::abs(now_.speed_mps));
    recent_.push_back(now_);
  }
  while (!recent_.empty() && (now_.t - recent_.front().t).s() > kRest_s) recent_.pop_front();
  const double gained_mps =
      recent_.empty() ? 0.0 : std::abs(now_.speed_mps - recent_.front().speed_mps);
  rides_ = rides_ || (has_stood_ && std::abs(height_m_) > kHeight_m && gained_mps > kSpeed_mps);
}

double LiftRide::speed_sigma_mps() const {
  const double t = duration_s();
  return std::sqrt(white_mps2_rthz_ * white_mps2_rthz_ * t + std::pow(force_sigma_mps2_ * t, 2) +
                   std::pow(kScale * fastest_mps_, 2));
}

bool LiftRide::is_steady() const {
  constexpr double kSteady_mps = 0.05;  // a lift that levels with its door changes speed by more
  if (recent_.empty()) return true;
  const auto [low, high] = std::minmax_element(
      recent_.begin(), recent_.end(),
      [](const Moment& a, const Moment& b) { return a.speed_mps < b.speed_mps; });
  return high->speed_mps - low->speed_mps < kSteady_mps;
}

bool LiftRide::is_long() const {
  return !recent_.empty() && (now_.t - recent_.front().t).s() > 0.95 * kRest_s;
}

bool LiftRide::stands() {
  if (rides_ || !is_steady()) return false;
  if (!is_long()) return true;
  has_stood_ = true;
  const double before_mps = recent_.front().speed_mps;
  begin_ = recent_.front().t;
  height_m_ = fastest_mps_ = 0.0;
  for (std::size_t k = 0; k < recent_.size(); ++k) {
    Moment& m = recent_[k];
    m.speed_mps -= before_mps;
    fastest_mps_ = std::max(fastest_mps_, std::abs(m.speed_mps));
    if (k == 0) continue;
    const Moment& last = recent_[k - 1];
    height_m_ += 0.5 * (m.t - last.t).s() * (m.speed_mps + last.speed_mps);
  }
  now_ = recent_.back();
  return true;
}

bool LiftRide::arrived() const {
  constexpr double kSlow_mps = 0.05;
  return rides_ && is_long() && is_steady() &&
         std::abs(now_.speed_mps) < std::max(kSlow_mps, 3.0 * speed_sigma_mps());
}

bool LiftRide::is_sensor_error() const {
  // Mine cages reach 16 m/s with 0.7 m/s2.
  constexpr double kLongest_s = 30.0;
  constexpr double kFastest_mps = 20.0;
  return std::abs(now_.speed_mps) > kFastest_mps ||
         (duration_s() > kLongest_s && std::abs(now_.speed_mps) > 0.9 * fastest_mps_ &&
          recent_.size() > 1 &&
          std::abs(now_.speed_mps - recent_.front().speed_mps) > 0.1 * kRest_s);
}

LiftRide::Height LiftRide::height() const {
  const double t = duration_s();
  const double white = white_mps2_rthz_ * white_mps2_rthz_ * t * t * t;
  const double scale = kScale * height_m_;
  if (!arrived()) {
    return {height_m_,
            std::sqrt(white / 3.0 + std::pow(0.5 * force_sigma_mps2_ * t * t, 2) + scale * scale)};
  }
  // A constant error of the force is what the speed at the end shows.
  constexpr double kLevel_m = 0.02;
  return {height_m_ - 0.5 * now_.speed_mps * t,
          std::sqrt(white / 12.0 + scale * scale + kLevel_m * kLevel_m)};
}

void remove_lift(const FilterState& held, std::span<ImuSample> samples) {
  const Vec3 up = up_in_body(held);
  const Vec3 rest = at_rest_mps2(held);
  for (ImuSample& sample : samples) {
    sample.accel_mps2 += up * up.dot(rest - sample.accel_mps2);
  }
}

}  // namespace rali::odometry
