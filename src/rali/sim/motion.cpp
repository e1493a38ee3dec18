#include "rali/sim/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rali/base/rng.hpp"

namespace rali::sim {

using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kSpacing_s = 0.02;   // of the spline's control points
constexpr double kSubstep_s = 0.001;  // of the suspension's integration
constexpr double kEnd_rest_s = 1.0;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Speed at every Route::kStep_m that keeps to the limits of bends and acceleration.
std::vector<double> speed_profile(const Route& route, const MotionOptions& o, Rng& rng) {
  const auto n = static_cast<std::size_t>(route.length_m() / Route::kStep_m) + 2;
  const double phase = rng.uniform(0.0, kTwoPi);
  const double wave_m = rng.uniform(15.0, 25.0);
  std::vector<double> v(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double s = static_cast<double>(i) * Route::kStep_m;
    const double cruise =
        o.speed_factor * o.speed_mps * (1.0 + 0.3 * std::sin(phase + kTwoPi * s / wave_m));
    const double bend = std::abs(route.curvature_at(s));
    v[i] = std::min(cruise, o.speed_factor * o.yaw_rate_max_radps / std::max(bend, 1e-3));
  }
  const double gain = 2.0 * o.acceleration_mps2 * o.speed_factor * Route::kStep_m;
  if (o.rest_s > 0.0) v.front() = 0.0;
  v.back() = 0.0;
  for (std::size_t i = 1; i < n; ++i) v[i] = std::min(v[i], std::sqrt(v[i - 1] * v[i - 1] + gain));
  for (std::size_t i = n - 1; i-- > 0;)
    v[i] = std::min(v[i], std::sqrt(v[i + 1] * v[i + 1] + gain));
  return v;
}

/// Way driven at every kSpacing_s: rest, drive, rest.
std::vector<double> way_over_time(const Route& route, const MotionOptions& o, Rng& rng) {
  const std::vector<double> profile = speed_profile(route, o, rng);
  const auto speed_at = [&](double s) {
    const double position =
        std::clamp(s / Route::kStep_m, 0.0, static_cast<double>(profile.size()) - 1.001);
    const auto i = static_cast<std::size_t>(position);
    return profile[i] + (position - std::floor(position)) * (profile[i + 1] - profile[i]);
  };
  std::vector<double> speed(static_cast<std::size_t>(o.rest_s / kSpacing_s), 0.0);
  constexpr std::size_t kLimit = 2'000'000;  // 11 h: no options lead there
  for (double s = 0.0; s < route.length_m() - 0.02 && speed.size() < kLimit;) {
    const double v = std::max(speed_at(s), 0.05 * o.speed_factor);
    speed.push_back(v);
    s += v * kSpacing_s;
  }
  speed.insert(speed.end(), static_cast<std::size_t>(kEnd_rest_s / kSpacing_s), 0.0);
  // A mean over 0.5 s limits the jerk: motors do not change force at once. Its window is cut at
  // the start of a recording that begins in motion.
  const int half = 12;
  const int n = static_cast<int>(speed.size());
  std::vector<double> way(speed.size(), 0.0);
  double s = 0.0;
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    int count = 0;
    for (int k = std::max(0, i - half); k <= std::min(n - 1, i + half); ++k, ++count) {
      sum += speed[static_cast<std::size_t>(k)];
    }
    way[static_cast<std::size_t>(i)] = s;
    s += sum / count * kSpacing_s;
  }
  return way;
}

/// Spring and damper with one mass, driven by a target (unit gain when standing).
class Spring {
 public:
  Spring(double frequency_hz, double damping) : w_(kTwoPi * frequency_hz), damping_(damping) {}

  double step(double target, double dt_s) {
    rate_ += dt_s * (w_ * w_ * (target - value_) - 2.0 * damping_ * w_ * rate_);
    value_ += dt_s * rate_;
    return value_;
  }

 private:
  double w_;
  double damping_;
  double value_ = 0.0;
  double rate_ = 0.0;
};

/// Uneven floor: low noise over the way and sometimes a sill or cable, per wheel side.
class Bumps {
 public:
  Bumps(double length_m, std::uint64_t seed) : rng_(seed, "bumps") {
    for (double s = rng_.uniform(2.0, 8.0); s < length_m; s += rng_.uniform(3.0, 12.0)) {
      bumps_.push_back(
          {s, rng_.uniform(0.08, 0.25), rng_.uniform(0.004, 0.015), rng_.uniform(-1.0, 1.0)});
    }
  }

  /// (height, tilt across) of the floor under the vehicle after s metres.
  geometry::Vec2 at(double s) {
    while (first_ < bumps_.size() && bumps_[first_].s_m + bumps_[first_].length_m < s) ++first_;
    if (first_ == bumps_.size() || bumps_[first_].s_m > s) return {0.0, 0.0};
    const Bump& b = bumps_[first_];
    const double height = b.height_m * 0.5 * (1.0 - std::cos(kTwoPi * (s - b.s_m) / b.length_m));
    return {height, b.side * height / 0.4};
  }

 private:
  struct Bump {
    double s_m, length_m, height_m, side;
  };

  Rng rng_;
  std::vector<Bump> bumps_;
  std::size_t first_ = 0;
};

/// Height, roll and pitch of a cart's body: springs answer to acceleration, steering and bumps.
class Suspension {
 public:
  Suspension(double length_m, std::uint64_t seed)
      : Suspension(length_m, seed, Rng(seed, "suspension")) {}

  /// @returns offsets (z [m], roll, pitch [rad]) after dt_s
  Vec3 step(double s_m, double a_long_mps2, double a_lat_mps2, double steer_radps2, double dt_s) {
    const geometry::Vec2 floor = bumps_.at(s_m);
    const double force = std::abs(a_long_mps2) + std::abs(a_lat_mps2);
    const double z = heave_.step(2.5 * floor.x() - 0.03 * force, dt_s);
    const double roll =
        roll_.step(0.05 * a_lat_mps2 + 0.015 * steer_radps2 + 1.5 * floor.y(), dt_s);
    const double pitch = pitch_.step(-0.05 * a_long_mps2 - 1.0 * floor.x(), dt_s);
    return {z, roll, pitch};
  }

 private:
  Suspension(double length_m, std::uint64_t seed, Rng rng)
      : heave_(rng.uniform(1.8, 4.0), rng.uniform(0.15, 0.3)),
        roll_(rng.uniform(1.5, 3.0), rng.uniform(0.15, 0.3)),
        pitch_(rng.uniform(1.8, 3.5), rng.uniform(0.15, 0.3)),
        bumps_(length_m, seed) {}

  Spring heave_, roll_, pitch_;
  Bumps bumps_;
};

/// Speeds and accelerations along the way at control point i, by differences.
struct WayState {
  double v, a_long, a_lat, steer;
};

WayState way_state(const Route& route, const std::vector<double>& way, std::size_t i) {
  const auto at = [&](std::ptrdiff_t k) {
    return way[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
        static_cast<std::ptrdiff_t>(i) + k, 0, static_cast<std::ptrdiff_t>(way.size()) - 1))];
  };
  const double v = (at(1) - at(-1)) / (2.0 * kSpacing_s);
  const double a = (at(1) - 2.0 * at(0) + at(-1)) / (kSpacing_s * kSpacing_s);
  const double yaw_rate = v * route.curvature_at(at(0));
  const double yaw_rate_before = v * route.curvature_at(at(-5));
  return {v, a, v * yaw_rate, (yaw_rate - yaw_rate_before) / (5.0 * kSpacing_s)};
}

/// Nobody drives along a line: slow swings to the sides that start and end at nothing.
class Wander {
 public:
  Wander(double length_m, double amplitude_m, std::uint64_t seed)
      : length_m_(length_m), amplitude_m_(amplitude_m) {
    Rng rng(seed, "wander");
    wave_m_ = {rng.uniform(6.0, 9.0), rng.uniform(13.0, 20.0)};
    phase_ = {rng.uniform(0.0, kTwoPi), rng.uniform(0.0, kTwoPi)};
  }

  /// Offset to the left [m] after s metres.
  [[nodiscard]] double at(double s_m) const {
    const double edge = std::clamp(std::min(s_m, length_m_ - s_m) / 4.0, 0.0, 1.0);
    const double fade = edge * edge * (3.0 - 2.0 * edge);
    return fade * amplitude_m_ *
           (0.4 * std::sin(kTwoPi * s_m / wave_m_[0] + phase_[0]) +
            0.6 * std::sin(kTwoPi * s_m / wave_m_[1] + phase_[1]));
  }

  [[nodiscard]] double slope(double s_m) const {
    constexpr double kHalf_m = 0.01;
    return (at(s_m + kHalf_m) - at(s_m - kHalf_m)) / (2.0 * kHalf_m);
  }

 private:
  double length_m_, amplitude_m_;
  std::array<double, 2> wave_m_{}, phase_{};
};

std::vector<Vec6> cart_controls(const Route& route, const std::vector<double>& way,
                                const MotionOptions& o, std::uint64_t seed) {
  Suspension suspension(route.length_m(), seed);
  const Wander wander(route.length_m(), o.wander_m, seed);
  std::vector<Vec6> controls(way.size());
  const int substeps = static_cast<int>(std::lround(kSpacing_s / kSubstep_s));
  for (std::size_t i = 0; i < way.size(); ++i) {
    const WayState w = way_state(route, way, i);
    Vec3 jolt = Vec3::Zero();
    for (int k = 0; k < substeps; ++k) {
      jolt = o.suspension *
             suspension.step(way[i] + w.v * kSubstep_s * k, w.a_long, w.a_lat, w.steer, kSubstep_s);
    }
    const double yaw = route.yaw_at(way[i]);
    const double aside = wander.at(way[i]);
    const Vec3 ground = route.point_at(way[i]) + aside * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
    const double climb = std::atan(route.slope_at(way[i]));
    controls[i] << ground.x(), ground.y(), ground.z() + o.body_height_m + jolt.x(), jolt.y(),
        jolt.z() - climb, yaw + std::atan(wander.slope(way[i]));
  }
  return controls;
}

/// Sum of two sinusoids with random phases, for the sway of hands and drones.
class Sway {
 public:
  Sway(double amplitude, double frequency_hz, Rng& rng)
      : amplitude_(amplitude),
        w_(kTwoPi * frequency_hz * rng.uniform(0.85, 1.15)),
        phase_(rng.uniform(0.0, kTwoPi)),
        phase_slow_(rng.uniform(0.0, kTwoPi)) {}

  [[nodiscard]] double at(double t_s) const {
    return amplitude_ *
           (0.65 * std::sin(w_ * t_s + phase_) + 0.35 * std::sin(0.37 * w_ * t_s + phase_slow_));
  }

 private:
  double amplitude_, w_, phase_, phase_slow_;
};

/// A person's gait (1.8 Hz steps) or a drone's slow six-degree-of-freedom drift.
std::vector<Vec6> free_controls(const Route& route, const std::vector<double>& way,
                                const MotionOptions& o, std::uint64_t seed) {
  Rng rng(seed, "sway");
  const bool drone = o.carrier == Carrier::kDrone;
  const double f = drone ? 0.35 : 0.9;
  const std::array<Sway, 6> sway{Sway(drone ? 0.25 : 0.04, f, rng),
                                 Sway(drone ? 0.25 : 0.04, f, rng),
                                 Sway(drone ? 0.35 : 0.03, drone ? 0.2 : 1.8, rng),
                                 Sway(drone ? 0.12 : 0.09, f, rng),
                                 Sway(drone ? 0.12 : 0.09, f, rng),
                                 Sway(drone ? 0.5 : 0.2, 0.5 * f, rng)};
  const double height = o.body_height_m + (drone ? 1.2 : 0.9);
  std::vector<Vec6> controls(way.size());
  double strength = 0.0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const double t = static_cast<double>(i) * kSpacing_s;
    // Sway grows over two seconds after the rest and never stops at once.
    if (way[i] > 0.0 || o.rest_s <= 0.0) strength = std::min(1.0, strength + kSpacing_s / 2.0);
    const double scale = strength * strength * (3.0 - 2.0 * strength) * o.suspension;
    const Vec3 ground = route.point_at(way[i]);
    controls[i] << ground.x(), ground.y(), ground.z() + height, 0.0, 0.0, route.yaw_at(way[i]);
    for (std::size_t k = 0; k < 6; ++k) {
      controls[i][static_cast<Eigen::Index>(k)] += scale * sway[k].at(t);
    }
  }
  return controls;
}

}  // namespace

Trajectory make_trajectory(const Route& route, const MotionOptions& options, std::uint64_t seed) {
  Rng rng(seed, "motion");
  const std::vector<double> way = way_over_time(route, options, rng);
  if (options.carrier == Carrier::kCart) {
    return {cart_controls(route, way, options, seed), kSpacing_s};
  }
  return {free_controls(route, way, options, seed), kSpacing_s};
}

}  // namespace rali::sim
