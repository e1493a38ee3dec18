#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/geometry/types.hpp"

namespace rali::sim {

/// Spring and damper with one mass, driven by a target (unit static gain).
class Spring {
 public:
  Spring(double frequency_hz, double damping);

  /// Value after dt_s of motion towards `target`.
  double step(double target, double dt_s);

 private:
  double w_, damping_;
  double value_ = 0.0;
  double rate_ = 0.0;
};

/// Uneven floor: an occasional sill or cable for each wheel side, without end.
class Bumps {
 public:
  explicit Bumps(std::uint64_t seed);

  /// (height [m], lateral tilt [rad]) of the floor under the vehicle after s metres; s never falls.
  [[nodiscard]] geometry::Vec2 at(double s_m);

 private:
  struct Bump {
    double s_m, length_m, height_m, side;
  };

  void draw_next();

  Rng rng_;
  double next_m_;
  Bump bump_{};
};

/// Motion of a vehicle at one instant.
struct DriveState {
  double v_mps = 0.0;
  double a_long_mps2 = 0.0;
  double a_lat_mps2 = 0.0;
  double steer_radps2 = 0.0;  ///< derivative of the yaw rate
};

/// Height, roll and pitch of a cart's body: springs respond to acceleration, steering and bumps.
class Suspension {
 public:
  explicit Suspension(std::uint64_t seed);

  /// Lets the springs settle under a constant drive, so that a recording that starts in motion has
  /// no initial transient.
  void settle(const DriveState& drive);

  /// @param s_m  distance driven so far, for the bumps
  /// @param dt_s  0.001 or so: explicit integration of springs up to 4 Hz
  /// @returns offsets (z [m], roll, pitch [rad]) after dt_s, not yet limited
  geometry::Vec3 step(double s_m, const DriveState& drive, double dt_s);

 private:
  Suspension(std::uint64_t seed, Rng rng);

  Spring heave_, roll_, pitch_;
  Bumps bumps_;
};

/// Limits the travel of the springs: no cart heaves by more than 0.1 m or tilts by more than 0.2
/// rad. Leaves the usual jolts (below 0.05 m, 0.1 rad) unchanged; the transition is smooth.
[[nodiscard]] geometry::Vec3 limited_jolt(const geometry::Vec3& jolt);

/// Slow lateral swings about the route, as real drivers make; zero at both ends.
class Wander {
 public:
  Wander(double length_m, double amplitude_m, std::uint64_t seed);

  /// Offset to the left [m] after s metres.
  [[nodiscard]] double at(double s_m) const;
  [[nodiscard]] double slope(double s_m) const;

 private:
  double length_m_, amplitude_m_;
  std::array<double, 2> wave_m_{}, phase_{};
};

/// Sway of a hand-held sensor (steps of 1.8 Hz) or of a drone (slow, in all six degrees of
/// freedom).
class Sway {
 public:
  Sway(bool drone, std::uint64_t seed);

  /// Offsets x y z [m], roll pitch yaw [rad] at full amplitude.
  [[nodiscard]] geometry::Vec6 at(double t_s) const;

 private:
  /// Sum of two sinusoids with random phases.
  struct Wave {
    Wave(double amplitude, double frequency_hz, Rng& rng);
    double amplitude, w, phase, phase_slow;
  };

  std::vector<Wave> waves_;
};

}  // namespace rali::sim
