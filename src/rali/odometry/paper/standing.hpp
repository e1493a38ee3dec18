#pragma once

#include <optional>

#include "rali/odometry/paper/inertial_guess.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/standstill.hpp"

namespace rali::odometry::paper {

/// Whether the vehicle stands: the paper's anchor is stationary, a recording does not say which
/// vehicle is the anchor. Decided as in preset robust, by inertial samples and the LiDAR's poses.
class Standing {
 public:
  Standing(const RobustSettings& settings, double gyro_radps_rthz);

  /// Samples in time order, in rad/s and m/s^2.
  void add(const sensor::ImuSample& sample);

  /// The wheels stood from `begin` to `end`: that is what the sensor measures then.
  void learn(Time begin, Time end);

  /// Call after each scan. @param degenerate_odom unit direction that the LiDAR does not constrain
  [[nodiscard]] bool update(Time t, const InertialGuess& guess,
                            const std::optional<geometry::Vec3>& degenerate_odom);

  void reset() { detector_.reset(); }

 private:
  StandstillDetector detector_;
  InertialBuffer samples_;
  Time t_sample_;
  double gyro_radps_rthz_;
};

}  // namespace rali::odometry::paper
