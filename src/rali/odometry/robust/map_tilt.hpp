#pragma once

#include <Eigen/Core>

#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// How fast a map tilts with the distance driven: a Gauss-Markov process.
struct TiltRate {
  double sigma_radpm = 0.0;
  double length_m = 1.0;  ///< distance over which it changes
};

/// Tilt of odom against the horizontal.
///
/// A map that is built scan by scan bends: lasers with elevation errors of 0.1 degrees tilt it by
/// some 0.01 degrees per metre in the direction of travel. No scan contradicts that. A filter that
/// assumes a straight map attributes the tilt to the accelerometer's bias, and where the LiDAR is
/// degenerate, integrates it to a speed. So gravity is that at the vehicle's place, and turns in
/// odom as the vehicle moves on; gravity at the first pose is a state of its own.

/// From here on the map tilts; gravity at this pose is that at the first one.
void begin_tilt(FilterState& state, const TiltRate& rate);

/// The rate's sigma is found to be another: estimate and sigma of the rate scale with it, and what
/// has tilted so far stays.
void scale_tilt(FilterState& state, double factor);

/// The vehicle has moved on: it turns in the map, and gravity with it. When it returns, both turn
/// back, since the turn is about the axis across the motion.
/// @param moved_odom_m since the last call
void tilt_with_map(FilterState& state, const geometry::Vec3& moved_odom_m, const TiltRate& rate);

/// Rotation of gravity in odom since the first pose, about x and y [rad]. The estimate is shrunk by
/// its own variance: zero where noise explains all of it.
[[nodiscard]] Eigen::Vector2d map_tilt_rad(const FilterState& state);

}  // namespace rali::odometry
