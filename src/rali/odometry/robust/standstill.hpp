#pragma once

#include <deque>
#include <optional>

#include "rali/imu/motion_noise.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Detects standstill from inertial samples, the filter's speed and the LiDAR's poses (algorithms
/// 2.6).
///
/// There are two ways. A driving vehicle shakes its inertial sensor. Once the sensor's noise at
/// standstill and the excess while driving are both known, the sensor alone proves standstill,
/// whatever the LiDAR measures. Until then, or if driving and standstill look alike, speed and
/// travel must be small along observable directions.
///
/// Special case: a degenerate LiDAR, no earlier standstill, and a sensor that is noisy or on a
/// running engine. Standstill and slow driving then look the same within a second. Within 15 s a
/// driving vehicle steers, turns or sways; one that does none of these is at standstill.
///
/// Each test asks whether noise alone explains the measurements. The allowed rate of false
/// rejections depends on their cost. Before standstill is detected, a rejection costs one window:
/// one in a hundred. Afterwards it is a false start, which lets the pose drift: one per hour of
/// standstill, all tests and scans together, unless the caller decides the end.
class StandstillDetector {
 public:
  /// @param false_starts_per_hour of standstill, by chance
  StandstillDetector(const ConstraintSettings& constraints, const imu::RestSettings& rest,
                     double false_starts_per_hour = 1.0)
      : constraints_(constraints), rest_(rest), false_starts_per_hour_(false_starts_per_hour) {}

  /// Learns the sensor's statistics at standstill.
  void learn(const imu::ImuStatistics& at_rest);

  /// Standstill at this pose since then: no window of standstill is needed first.
  void stood_since(Time t, const geometry::SE3& T_odom_body);

  /// Call after each scan. @param degenerate_axis unit direction in odom along which the LiDAR
  /// cannot observe motion, if there is one. @param gyro_radps_rthz lower bound of the gyro's noise
  /// density.
  /// @return true at standstill.
  bool update(const FilterState& state, const InertialBuffer& imu,
              const std::optional<geometry::Vec3>& degenerate_axis, double gyro_radps_rthz);

  /// As if no force acted along gravity: the vehicle may stand in a lift that moves.
  /// @param held its state at the last standstill
  [[nodiscard]] bool stands_in_lift(const FilterState& held, Time now, const InertialBuffer& imu,
                                    double gyro_radps_rthz) const;

  /// The sensor shows no more than its noise at standstill, and the speed is low.
  [[nodiscard]] bool calm(const FilterState& state, const InertialBuffer& imu) const;

  /// The last update() was decided by the inertial sensor alone.
  [[nodiscard]] bool certain() const { return certain_; }

  /// White noise density of the sensor at standstill; nothing before the first standstill.
  [[nodiscard]] std::optional<imu::NoiseDensity> rest_density() const;

  void reset() {
    recent_.clear();
    stands_since_.reset();
  }

  [[nodiscard]] double window_s() const { return constraints_.rest_after_s; }

  /// Length of inertial data that update() needs.
  [[nodiscard]] double memory_s() const;

 private:
  struct Moment {
    Time t;
    geometry::SE3 T;
  };

  /// Probability with which one test may reject standstill by chance, now.
  [[nodiscard]] double chance(Time now) const;
  [[nodiscard]] bool wheels_stand(const imu::ImuStatistics& raw) const;
  [[nodiscard]] bool still_for_long(const FilterState& state, const InertialBuffer& imu,
                                    const geometry::Vec3& degenerate_axis) const;
  [[nodiscard]] bool quiet(const imu::ImuStatistics& blocks, double chance) const;
  [[nodiscard]] bool driving_shakes() const;
  [[nodiscard]] bool moves_visibly(const FilterState& state, const geometry::Mat3& seen) const;
  [[nodiscard]] bool turns(const FilterState& state, const imu::ImuStatistics& blocks,
                           double gyro_radps_rthz, double chance) const;
  [[nodiscard]] bool pushed(const FilterState& state, const imu::ImuStatistics& blocks,
                            const imu::ImuStatistics& raw, double chance) const;
  void learn_driving(const FilterState& state, const std::vector<sensor::ImuSample>& window);
  void learn_standing(Time t, bool stands, const imu::ImuStatistics& raw);

  ConstraintSettings constraints_;
  imu::RestSettings rest_;
  double false_starts_per_hour_ = 1.0;
  std::optional<imu::ImuStatistics> at_rest_;
  /// Shaking that most windows of driving exceed, accelerometer and gyro, norms.
  double driving_accel_mps2_ = 0.0, driving_gyro_radps_ = 0.0;
  int driving_windows_ = 0;
  std::deque<Moment> recent_;
  std::optional<Time> stands_since_, drives_since_;
  bool certain_ = false;
};

/// Propagation at standstill: the pose is kept, the velocity is zero, and the sensor measures its
/// biases and gravity.
void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise);

}  // namespace rali::odometry
