#pragma once

#include <deque>
#include <optional>

#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Decides from inertial samples, the filter's speed and the LiDAR's poses whether the vehicle
/// stands (algorithms 2.6). Where the LiDAR cannot see the motion, nothing is proven.
class StandstillDetector {
 public:
  StandstillDetector(const ConstraintSettings& constraints, const imu::RestSettings& rest,
                     const ImuNoiseSettings& noise)
      : constraints_(constraints), rest_(rest), noise_(noise) {}

  /// What the sensor measures while the wheels stand. Known, it proves rest where the LiDAR is
  /// blind: wheels that roll shake.
  void learn(const imu::ImuStatistics& at_rest);

  /// Call after each scan. @param blind_axis unit direction in odom along which the LiDAR cannot
  /// see motion, if there is one. @return true while the vehicle stands.
  bool update(const FilterState& state, const InertialBuffer& imu,
              const std::optional<geometry::Vec3>& blind_axis = std::nullopt);

  void reset() { recent_.clear(); }

  [[nodiscard]] double window_s() const { return constraints_.rest_after_s; }

 private:
  struct Moment {
    Time t;
    geometry::Vec3 p;
  };

  [[nodiscard]] bool wheels_stand(const imu::ImuStatistics& raw) const;

  ConstraintSettings constraints_;
  imu::RestSettings rest_;
  ImuNoiseSettings noise_;
  std::optional<imu::ImuStatistics> at_rest_;
  std::deque<Moment> recent_;
};

/// Propagation while the pose is held: attitude and position stay, velocity and biases evolve.
/// Followed by "velocity is zero" and "the gyro measures its bias", it learns the biases without
/// touching what is known about the pose.
void propagate_held(FilterState& state, const InertialBuffer& buffer, Time t_end,
                    const ImuNoiseSettings& noise);

}  // namespace rali::odometry
