#pragma once

#include <array>
#include <optional>
#include <vector>

#include "rali/sim/motion.hpp"
#include "rali/sim/suspension.hpp"
#include "rali/sim/world.hpp"

namespace rali::sim {

/// One vehicle driven step by step: a differential drive with suspension that turns on the spot,
/// follows paths, waits and stops. Its trajectory grows tick by tick. It is twice differentiable
/// whatever the commands are, so its inertial samples are exact.
class Rover {
 public:
  static constexpr double kTick_s = 0.02;  ///< time between control points of the trajectory

  /// Starts at `start` after three ticks of standstill (a spline needs four points).
  Rover(const MotionOptions& options, const VehicleStart& start, std::uint64_t seed);

  /// Follows these corners on the ground from its current position; only if idle(). First corners
  /// closer than 0.1 m to the vehicle are left out; with none left it stays idle.
  void follow(const std::vector<geometry::Vec3>& corners, double rounding_m);

  /// Brakes; with false it continues along its path.
  void hold(bool waiting) { holding_ = waiting; }

  /// Brakes to a stop and discards its path.
  void halt();

  /// One tick.
  void step();

  /// At standstill without a path to follow.
  [[nodiscard]] bool idle() const { return !route_.has_value(); }

  /// Does not move, neither along its path nor turning.
  [[nodiscard]] bool standing() const;

  [[nodiscard]] const geometry::Vec3& ground() const { return ground_; }

  [[nodiscard]] double yaw_rad() const { return yaw_; }

  [[nodiscard]] double speed_mps() const { return smooth_; }

  /// Its position on the ground `ahead_m` further along its path (at most the end).
  [[nodiscard]] geometry::Vec3 ground_ahead(double ahead_m) const;

  /// Distance needed to stop.
  [[nodiscard]] double stopping_m() const;

  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }

 private:
  static constexpr std::size_t kSmooth = 25;  ///< ticks of the moving average that limits the jerk
  static constexpr std::size_t kSteer = 5;    ///< ticks over which the steering rate is computed

  /// Turn on the spot before a path.
  struct Turn {
    double from_rad = 0.0, by_rad = 0.0;
    double from_climb_rad = 0.0, by_climb_rad = 0.0;
    double done_s = 0.0, whole_s = 0.0;
  };

  void turn();
  void drive();
  [[nodiscard]] double wished_speed() const;
  [[nodiscard]] geometry::Vec3 on_path(double s_m) const;
  [[nodiscard]] geometry::Vec6 offsets(const DriveState& drive);
  [[nodiscard]] Trajectory::Control control(const geometry::Vec6& offsets) const;

  MotionOptions options_;
  std::uint64_t seed_;
  std::uint64_t legs_ = 0;
  Suspension suspension_;
  std::optional<Sway> sway_;
  double sway_strength_ = 0.0;
  double time_s_ = 0.0;

  std::optional<Route> route_;
  std::optional<SpeedProfile> profile_;
  std::optional<Wander> wander_;
  std::optional<Turn> turn_;
  double yaw_offset_ = 0.0;  ///< whole turns between the route's heading and the vehicle's
  bool holding_ = false, halting_ = false, at_end_ = false;

  double wish_ = 0.0;    ///< commanded speed before smoothing
  double wish_m_ = 0.0;  ///< distance integrated from it
  std::array<double, kSmooth> wishes_{};
  std::size_t tick_ = 0;
  double smooth_ = 0.0;  ///< speed
  double path_m_ = 0.0;  ///< on the route
  double driven_m_ = 0.0;
  double turn_rate_ = 0.0;
  std::array<double, kSteer> yaw_rates_{};
  double accel_ = 0.0, mean_speed_ = 0.0;

  geometry::Vec3 ground_;
  double yaw_, climb_ = 0.0;
  Trajectory trajectory_;
};

}  // namespace rali::sim
