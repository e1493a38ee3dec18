#include "rali/sim/fleet/rover.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kSubstep_s = 0.001;  // of the suspension's integration
constexpr double kEnd_m = 0.02;       // a path ends this early, as in make_trajectory()

double carried_height_m(const MotionOptions& o) {
  const double hand = o.carrier == Carrier::kDrone ? 1.2 : 0.9;
  return o.body_height_m + (o.carrier == Carrier::kCart ? 0.0 : hand);
}

Trajectory standing_still(const MotionOptions& o, const VehicleStart& start) {
  Vec6 q;
  q << start.p_world_m.x(), start.p_world_m.y(), start.p_world_m.z() + carried_height_m(o), 0.0,
      0.0, start.yaw_rad;
  return {std::vector<Vec6>(4, q), Rover::kTick_s};
}

}  // namespace

Rover::Rover(const MotionOptions& options, const VehicleStart& start, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      suspension_(seed),
      ground_(start.p_world_m),
      yaw_(start.yaw_rad),
      trajectory_(standing_still(options, start)) {
  if (const Jolts jolts(options_.jolts, seed); !jolts.empty()) trajectory_.add_jolts(jolts);
  if (options_.carrier != Carrier::kCart) sway_.emplace(options_.carrier == Carrier::kDrone, seed);
}

bool Rover::standing() const { return !turn_ && wish_ == 0.0 && smooth_ == 0.0; }

void Rover::follow(const std::vector<Vec3>& corners, double rounding_m) {
  RALI_ASSERT(idle());
  constexpr double kThere_m = 0.1;
  std::vector<Vec3> path{ground_};
  for (const Vec3& corner : corners) {
    const double apart_m = (corner - path.back()).norm();
    if (apart_m >= (path.size() == 1 ? kThere_m : 1e-3)) path.push_back(corner);
  }
  if (path.size() < 2) return;
  Rng rng(seed_, "leg " + std::to_string(legs_++));
  route_.emplace(path, rounding_m);
  profile_.emplace(*route_, options_, true, rng);
  wander_.emplace(route_->length_m(), options_.wander_m, rng.next());
  const double heading = route_->yaw_at(0.0);
  const double by = std::remainder(heading - yaw_, 2.0 * std::numbers::pi);
  yaw_offset_ = yaw_ + by - heading;
  const double climb = std::atan(route_->slope_at(0.0));
  // The peak rate of this profile is 1.875 times its mean rate.
  const double whole_s =
      std::max(0.6, 1.875 * std::abs(by) / (options_.yaw_rate_max_radps * options_.speed_factor));
  turn_ = Turn{yaw_, by, climb_, climb - climb_, 0.0, whole_s};
  wish_ = wish_m_ = path_m_ = 0.0;
  halting_ = at_end_ = false;
}

void Rover::halt() { halting_ = true; }

Vec3 Rover::on_path(double s_m) const {
  const double yaw = route_->yaw_at(s_m);
  return route_->point_at(s_m) + wander_->at(s_m) * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
}

Vec3 Rover::ground_ahead(double ahead_m) const {
  if (!route_) return ground_;
  return on_path(std::min(path_m_ + ahead_m, route_->length_m()));
}

double Rover::stopping_m() const {
  const double deceleration = options_.acceleration_mps2 * options_.speed_factor;
  // Smoothing delays the commanded speed, so distance already commanded is still driven.
  return (wish_m_ - path_m_) + wish_ * wish_ / (2.0 * deceleration);
}

/// Smooth in heading, rate and acceleration (minimum-jerk profile).
void Rover::turn() {
  Turn& t = *turn_;
  t.done_s = std::min(t.done_s + kTick_s, t.whole_s);
  const double u = t.done_s / t.whole_s;
  const double fraction = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
  yaw_ = t.from_rad + t.by_rad * fraction;
  climb_ = t.from_climb_rad + t.by_climb_rad * fraction;
  turn_rate_ = t.by_rad * 30.0 * u * u * (1.0 - u) * (1.0 - u) / t.whole_s;
  if (t.done_s >= t.whole_s) turn_.reset();
}

double Rover::wished_speed() const {
  const double step = options_.acceleration_mps2 * options_.speed_factor * kTick_s;
  if (at_end_) return 0.0;
  const double limit = std::max(profile_->at(wish_m_), 0.05 * options_.speed_factor);
  if (holding_ || halting_) return std::min(limit, std::max(0.0, wish_ - step));
  return std::min(limit, std::max(wish_ + step, 0.05 * options_.speed_factor));
}

void Rover::drive() {
  wish_ = wished_speed();
  wish_m_ += wish_ * kTick_s;
  if (wish_m_ >= route_->length_m() - kEnd_m) at_end_ = true;
  path_m_ = std::min(path_m_ + smooth_ * kTick_s, route_->length_m());
  driven_m_ += smooth_ * kTick_s;
  wishes_[tick_ % kSmooth] = wish_;
  double sum = 0.0;
  for (const double w : wishes_) sum += w;
  const double before = smooth_;
  smooth_ = sum / static_cast<double>(kSmooth);
  mean_speed_ = 0.5 * (before + smooth_);
  accel_ = (smooth_ - before) / kTick_s;
  ground_ = on_path(path_m_);
  yaw_ = route_->yaw_at(path_m_) + yaw_offset_ + std::atan(wander_->slope(path_m_));
  climb_ = std::atan(route_->slope_at(path_m_));
}

Vec6 Rover::offsets(const DriveState& drive) {
  Vec6 out = Vec6::Zero();
  if (!sway_) {
    Vec3 jolt = Vec3::Zero();
    for (int k = 0; k < static_cast<int>(kTick_s / kSubstep_s + 0.5); ++k) {
      jolt = suspension_.step(driven_m_ + drive.v_mps * kSubstep_s * k, drive, kSubstep_s);
    }
    jolt = limited_jolt(options_.suspension * jolt);
    out.segment<3>(2) = jolt;
    out[4] -= climb_;
    return out;
  }
  // A standing person sways little, a hovering drone as in flight; before the first path both are
  // down.
  const double idle_sway = options_.carrier == Carrier::kDrone ? 1.0 : 0.3;
  const double goal = legs_ == 0 ? 0.0 : (standing() ? idle_sway : 1.0);
  const double step = kTick_s / 2.0;
  sway_strength_ += std::clamp(goal - sway_strength_, -step, step);
  const double scale = sway_strength_ * sway_strength_ * (3.0 - 2.0 * sway_strength_);
  return scale * options_.suspension * sway_->at(time_s_);
}

Trajectory::Control Rover::control(const Vec6& offsets) const {
  Trajectory::Control q;
  q << ground_.x(), ground_.y(), ground_.z() + carried_height_m(options_), 0.0, 0.0, yaw_;
  return q + offsets;
}

void Rover::step() {
  turn_rate_ = accel_ = mean_speed_ = 0.0;
  if (turn_) {
    turn();
  } else if (route_) {
    drive();
    if ((at_end_ || halting_) && standing()) {
      route_.reset();
      halting_ = false;
    }
  } else {
    halting_ = false;
  }
  const double bend = route_ ? route_->curvature_at(path_m_) : 0.0;
  const double yaw_rate = mean_speed_ * bend + turn_rate_;
  double& oldest = yaw_rates_[tick_ % kSteer];
  const double steer = (yaw_rate - oldest) / (static_cast<double>(kSteer) * kTick_s);
  oldest = yaw_rate;
  const DriveState drive{mean_speed_, accel_, mean_speed_ * yaw_rate, steer};
  trajectory_.append(control(offsets(drive)));
  ++tick_;
  time_s_ += kTick_s;
}

}  // namespace rali::sim
