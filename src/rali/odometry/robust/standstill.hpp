#pragma once

#include <deque>
#include <optional>

#include "rali/imu/motion_noise.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Decides from inertial samples, the filter's speed and the LiDAR's poses whether the vehicle
/// stands (algorithms 2.6).
///
/// Two ways lead there. A vehicle that drives shakes its inertial sensor; once both are known, what
/// the sensor measures at standstill and how much more it measures while driving, the sensor alone
/// proves standstill, whatever the LiDAR seems to see. Until then, or where driving cannot be told
/// from standing, speed and travel must be small where the LiDAR knows them.
///
/// A vehicle that has not stood yet where its LiDAR is degenerate, with a sensor that is noisy or
/// on a running engine: standstill and slow driving look the same within a second. In 15 s whoever
/// drives steers, turns or sways; who does not, stands.
///
/// Each test asks whether noise alone explains what the sensor measures. How often it may say no of
/// a vehicle that stands depends on what that costs. Before the vehicle is taken for standing it is
/// a window lost: one in a hundred. Afterwards it is a false start, which lets the pose drift: one
/// in an hour of standing, all tests and scans together, unless somebody else decides the end.
class StandstillDetector {
 public:
  /// @param false_starts_per_hour of standing, by chance
  StandstillDetector(const ConstraintSettings& constraints, const imu::RestSettings& rest,
                     double false_starts_per_hour = 1.0)
      : constraints_(constraints), rest_(rest), false_starts_per_hour_(false_starts_per_hour) {}

  /// What the sensor measures while the wheels stand.
  void learn(const imu::ImuStatistics& at_rest);

  /// The vehicle has stood at this pose since then: no window of standing is waited for.
  void stood_since(Time t, const geometry::SE3& T_odom_body);

  /// Call after each scan. @param blind_axis unit direction in odom along which the LiDAR cannot
  /// see motion, if there is one. @param gyro_radps_rthz density of the gyro's noise, at least.
  /// @return true while the vehicle stands.
  bool update(const FilterState& state, const InertialBuffer& imu,
              const std::optional<geometry::Vec3>& blind_axis, double gyro_radps_rthz);

  /// The sensor feels no more than at standstill, and nothing else tells of motion.
  [[nodiscard]] bool calm(const FilterState& state, const InertialBuffer& imu) const;

  /// The last update() was decided by the inertial sensor alone.
  [[nodiscard]] bool certain() const { return certain_; }

  /// Density of the white noise that the sensor shows at standstill; nothing until it has stood.
  [[nodiscard]] std::optional<imu::NoiseDensity> rest_density() const;

  void reset() {
    recent_.clear();
    stands_since_.reset();
  }

  [[nodiscard]] double window_s() const { return constraints_.rest_after_s; }

  /// Inertial samples of so long are asked for.
  [[nodiscard]] double memory_s() const;

 private:
  struct Moment {
    Time t;
    geometry::SE3 T;
  };

  /// What one test may say of a vehicle that stands by chance, now.
  [[nodiscard]] double chance(Time now) const;
  [[nodiscard]] bool wheels_stand(const imu::ImuStatistics& raw) const;
  [[nodiscard]] bool still_for_long(const FilterState& state, const InertialBuffer& imu,
                                    const geometry::Vec3& blind_axis) const;
  [[nodiscard]] bool quiet(const imu::ImuStatistics& blocks, double chance) const;
  [[nodiscard]] bool driving_shakes() const;
  [[nodiscard]] bool moves_visibly(const FilterState& state, const geometry::Mat3& seen) const;
  [[nodiscard]] bool turns(const FilterState& state, const imu::ImuStatistics& blocks,
                           double gyro_radps_rthz, double chance) const;
  [[nodiscard]] bool pushed(const FilterState& state, const imu::ImuStatistics& blocks,
                            const imu::ImuStatistics& raw, double chance) const;
  void learn_driving(const FilterState& state, const imu::ImuStatistics& raw);
  void learn_standing(Time t, bool stands, const imu::ImuStatistics& raw);

  ConstraintSettings constraints_;
  imu::RestSettings rest_;
  double false_starts_per_hour_ = 1.0;
  std::optional<imu::ImuStatistics> at_rest_;
  /// Spread that most windows of driving exceed, accelerometer and gyro, norms.
  double driving_accel_mps2_ = 0.0, driving_gyro_radps_ = 0.0;
  std::deque<Moment> recent_;
  std::optional<Time> stands_since_, drives_since_;
  bool certain_ = false;
};

/// Propagation while the pose is held: the pose stays, the velocity is zero, and what the sensor
/// feels is its biases and gravity.
void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ProcessNoise& noise);

}  // namespace rali::odometry
