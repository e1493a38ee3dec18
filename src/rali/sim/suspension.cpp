#include "rali/sim/suspension.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::sim {

using geometry::Vec2;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// x up to `free`, then a smooth approach to `stop`; twice differentiable.
double stopped(double x, double free, double stop) {
  const double over = std::abs(x) - free;
  if (over <= 0.0) return x;
  const double room = stop - free;
  return std::copysign(free + room * std::tanh(over / room), x);
}

}  // namespace

Spring::Spring(double frequency_hz, double damping)
    : w_(kTwoPi * frequency_hz), damping_(damping) {}

double Spring::step(double target, double dt_s) {
  rate_ += dt_s * (w_ * w_ * (target - value_) - 2.0 * damping_ * w_ * rate_);
  value_ += dt_s * rate_;
  return value_;
}

Bumps::Bumps(std::uint64_t seed) : rng_(seed, "bumps"), next_m_(rng_.uniform(2.0, 8.0)) {
  draw_next();
}

void Bumps::draw_next() {
  const double length_m = rng_.uniform(0.08, 0.25);
  const double height_m = rng_.uniform(0.004, 0.015);
  const double side = rng_.uniform(-1.0, 1.0);
  bump_ = {next_m_, length_m, height_m, side};
  next_m_ += rng_.uniform(3.0, 12.0);
}

Vec2 Bumps::at(double s_m) {
  while (bump_.s_m + bump_.length_m < s_m) draw_next();
  if (bump_.s_m > s_m) return {0.0, 0.0};
  const double height =
      bump_.height_m * 0.5 * (1.0 - std::cos(kTwoPi * (s_m - bump_.s_m) / bump_.length_m));
  return {height, bump_.side * height / 0.4};
}

Suspension::Suspension(std::uint64_t seed) : Suspension(seed, Rng(seed, "suspension")) {}

Suspension::Suspension(std::uint64_t seed, Rng rng)
    : heave_(rng.uniform(1.8, 4.0), rng.uniform(0.15, 0.3)),
      roll_(rng.uniform(1.5, 3.0), rng.uniform(0.15, 0.3)),
      pitch_(rng.uniform(1.8, 3.5), rng.uniform(0.15, 0.3)),
      bumps_(seed) {}

void Suspension::settle(const DriveState& drive) {
  constexpr double kStep_s = 0.001;
  constexpr int kSteps = 5000;  // the slowest spring (1.5 Hz, damping 0.15) falls to e^-7
  for (int i = 0; i < kSteps; ++i) step(0.0, drive, kStep_s);
}

Vec3 Suspension::step(double s_m, const DriveState& drive, double dt_s) {
  const Vec2 floor = bumps_.at(s_m);
  const double force = std::abs(drive.a_long_mps2) + std::abs(drive.a_lat_mps2);
  const double z = heave_.step(2.5 * floor.x() - 0.03 * force, dt_s);
  const double roll =
      roll_.step(0.05 * drive.a_lat_mps2 + 0.015 * drive.steer_radps2 + 1.5 * floor.y(), dt_s);
  const double pitch = pitch_.step(-0.05 * drive.a_long_mps2 - 1.0 * floor.x(), dt_s);
  return {z, roll, pitch};
}

Vec3 limited_jolt(const Vec3& jolt) {
  return {stopped(jolt.x(), 0.05, 0.1), stopped(jolt.y(), 0.1, 0.2), stopped(jolt.z(), 0.1, 0.2)};
}

Wander::Wander(double length_m, double amplitude_m, std::uint64_t seed)
    : length_m_(length_m), amplitude_m_(amplitude_m) {
  Rng rng(seed, "wander");
  wave_m_ = {rng.uniform(6.0, 9.0), rng.uniform(13.0, 20.0)};
  phase_ = {rng.uniform(0.0, kTwoPi), rng.uniform(0.0, kTwoPi)};
}

double Wander::at(double s_m) const {
  const double edge = std::clamp(std::min(s_m, length_m_ - s_m) / 4.0, 0.0, 1.0);
  const double fade = edge * edge * (3.0 - 2.0 * edge);
  return fade * amplitude_m_ *
         (0.4 * std::sin(kTwoPi * s_m / wave_m_[0] + phase_[0]) +
          0.6 * std::sin(kTwoPi * s_m / wave_m_[1] + phase_[1]));
}

double Wander::slope(double s_m) const {
  constexpr double kHalf_m = 0.01;
  return (at(s_m + kHalf_m) - at(s_m - kHalf_m)) / (2.0 * kHalf_m);
}

Sway::Wave::Wave(double amplitude_in, double frequency_hz, Rng& rng)
    : amplitude(amplitude_in),
      w(kTwoPi * frequency_hz * rng.uniform(0.85, 1.15)),
      phase(rng.uniform(0.0, kTwoPi)),
      phase_slow(rng.uniform(0.0, kTwoPi)) {}

Sway::Sway(bool drone, std::uint64_t seed) {
  Rng rng(seed, "sway");
  const double f = drone ? 0.35 : 0.9;
  waves_ = {Wave(drone ? 0.25 : 0.04, f, rng),
            Wave(drone ? 0.25 : 0.04, f, rng),
            Wave(drone ? 0.35 : 0.03, drone ? 0.2 : 1.8, rng),
            Wave(drone ? 0.12 : 0.09, f, rng),
            Wave(drone ? 0.12 : 0.09, f, rng),
            Wave(drone ? 0.5 : 0.2, 0.5 * f, rng)};
}

Vec6 Sway::at(double t_s) const {
  Vec6 out;
  for (std::size_t k = 0; k < 6; ++k) {
    const Wave& m = waves_[k];
    out[static_cast<Eigen::Index>(k)] =
        m.amplitude *
        (0.65 * std::sin(m.w * t_s + m.phase) + 0.35 * std::sin(0.37 * m.w * t_s + m.phase_slow));
  }
  return out;
}

}  // namespace rali::sim
