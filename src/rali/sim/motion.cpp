#include "rali/sim/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/base/rng.hpp"
#include "rali/sim/suspension.hpp"

namespace rali::sim {

using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kSpacing_s = 0.02;   // of the spline's control points
constexpr double kSubstep_s = 0.001;  // of the suspension's integration
constexpr double kEnd_rest_s = 1.0;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Distance driven at every kSpacing_s: standstill, drive, standstill.
std::vector<double> path_over_time(const Route& route, const MotionOptions& o, Rng& rng) {
  const SpeedProfile profile(route, o, o.standstill_s > 0.0, rng);
  std::vector<double> speed(static_cast<std::size_t>(o.standstill_s / kSpacing_s), 0.0);
  constexpr std::size_t kLimit = 2'000'000;  // 11 h: no valid options reach it
  for (double s = 0.0; s < route.length_m() - 0.02 && speed.size() < kLimit;) {
    const double v = std::max(profile.at(s), 0.05 * o.speed_factor);
    speed.push_back(v);
    s += v * kSpacing_s;
  }
  speed.insert(speed.end(), static_cast<std::size_t>(kEnd_rest_s / kSpacing_s), 0.0);
  // A moving average over 0.5 s limits the jerk: motors do not change force at once. The window is
  // truncated at the start of a recording that begins in motion.
  const int half = 12;
  const int n = static_cast<int>(speed.size());
  std::vector<double> path(speed.size(), 0.0);
  double s = 0.0;
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    int count = 0;
    for (int k = std::max(0, i - half); k <= std::min(n - 1, i + half); ++k, ++count) {
      sum += speed[static_cast<std::size_t>(k)];
    }
    path[static_cast<std::size_t>(i)] = s;
    s += sum / count * kSpacing_s;
  }
  return path;
}

/// Motion of the vehicle at control point i, by differences.
DriveState drive_state(const Route& route, const std::vector<double>& path, std::size_t i) {
  const auto n = static_cast<std::ptrdiff_t>(path.size());
  const double first_step = path[1] - path[0];
  const auto at = [&](std::ptrdiff_t k) {
    const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
    // Before the recording the vehicle moved with its initial speed.
    if (j < 0) return path[0] + static_cast<double>(j) * first_step;
    return path[static_cast<std::size_t>(std::min(j, n - 1))];
  };
  const double v = (at(1) - at(-1)) / (2.0 * kSpacing_s);
  const double a = (at(1) - 2.0 * at(0) + at(-1)) / (kSpacing_s * kSpacing_s);
  const double yaw_rate = v * route.curvature_at(at(0));
  const double yaw_rate_before = v * route.curvature_at(at(-5));
  return {v, a, v * yaw_rate, (yaw_rate - yaw_rate_before) / (5.0 * kSpacing_s)};
}

std::vector<Vec6> cart_controls(const Route& route, const std::vector<double>& path,
                                const MotionOptions& o, std::uint64_t seed) {
  Suspension suspension(seed);
  const Wander wander(route.length_m(), o.wander_m, seed);
  std::vector<Vec6> controls(path.size());
  const int substeps = static_cast<int>(std::lround(kSpacing_s / kSubstep_s));
  suspension.settle(drive_state(route, path, 0));
  for (std::size_t i = 0; i < path.size(); ++i) {
    const DriveState drive = drive_state(route, path, i);
    Vec3 jolt = Vec3::Zero();
    for (int k = 0; k < substeps; ++k) {
      jolt = suspension.step(path[i] + drive.v_mps * kSubstep_s * k, drive, kSubstep_s);
    }
    jolt = limited_jolt(o.suspension * jolt);
    const double yaw = route.yaw_at(path[i]);
    const double lateral = wander.at(path[i]);
    const Vec3 ground =
        route.point_at(path[i]) + lateral * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
    const double climb = std::atan(route.slope_at(path[i]));
    controls[i] << ground.x(), ground.y(), ground.z() + o.body_height_m + jolt.x(), jolt.y(),
        jolt.z() - climb, yaw + std::atan(wander.slope(path[i]));
  }
  return controls;
}

std::vector<Vec6> free_controls(const Route& route, const std::vector<double>& path,
                                const MotionOptions& o, std::uint64_t seed) {
  const bool drone = o.carrier == Carrier::kDrone;
  const Sway sway(drone, seed);
  const double height = o.body_height_m + (drone ? 1.2 : 0.9);
  std::vector<Vec6> controls(path.size());
  // Sway grows over two seconds after the standstill and does not stop at the end. A recording that
  // begins in motion begins at full sway.
  double strength = o.standstill_s > 0.0 ? 0.0 : 1.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] > 0.0) strength = std::min(1.0, strength + kSpacing_s / 2.0);
    const double scale = strength * strength * (3.0 - 2.0 * strength) * o.suspension;
    const Vec3 ground = route.point_at(path[i]);
    controls[i] << ground.x(), ground.y(), ground.z() + height, 0.0, 0.0, route.yaw_at(path[i]);
    controls[i] += scale * sway.at(static_cast<double>(i) * kSpacing_s);
  }
  return controls;
}

}  // namespace

SpeedProfile::SpeedProfile(const Route& route, const MotionOptions& o, bool from_rest, Rng& rng)
    : v_mps_(static_cast<std::size_t>(route.length_m() / Route::kStep_m) + 2) {
  const std::size_t n = v_mps_.size();
  const double phase = rng.uniform(0.0, kTwoPi);
  const double wave_m = rng.uniform(15.0, 25.0);
  for (std::size_t i = 0; i < n; ++i) {
    const double s = static_cast<double>(i) * Route::kStep_m;
    const double cruise =
        o.speed_factor * o.speed_mps * (1.0 + 0.3 * std::sin(phase + kTwoPi * s / wave_m));
    const double bend = std::abs(route.curvature_at(s));
    v_mps_[i] = std::min(cruise, o.speed_factor * o.yaw_rate_max_radps / std::max(bend, 1e-3));
  }
  const double gain = 2.0 * o.acceleration_mps2 * o.speed_factor * Route::kStep_m;
  if (from_rest) v_mps_.front() = 0.0;
  v_mps_.back() = 0.0;
  for (std::size_t i = 1; i < n; ++i)
    v_mps_[i] = std::min(v_mps_[i], std::sqrt(v_mps_[i - 1] * v_mps_[i - 1] + gain));
  for (std::size_t i = n - 1; i-- > 0;)
    v_mps_[i] = std::min(v_mps_[i], std::sqrt(v_mps_[i + 1] * v_mps_[i + 1] + gain));
}

double SpeedProfile::at(double s_m) const {
  const double position =
      std::clamp(s_m / Route::kStep_m, 0.0, static_cast<double>(v_mps_.size()) - 1.001);
  const auto i = static_cast<std::size_t>(position);
  return v_mps_[i] + (position - std::floor(position)) * (v_mps_[i + 1] - v_mps_[i]);
}

Trajectory make_trajectory(const Route& route, const MotionOptions& options, std::uint64_t seed) {
  Rng rng(seed, "motion");
  const std::vector<double> path = path_over_time(route, options, rng);
  const bool cart = options.carrier == Carrier::kCart;
  Trajectory trajectory(
      cart ? cart_controls(route, path, options, seed) : free_controls(route, path, options, seed),
      kSpacing_s);
  if (const Jolts jolts(options.jolts, seed); !jolts.empty()) trajectory.add_jolts(jolts);
  return trajectory;
}

}  // namespace rali::sim
