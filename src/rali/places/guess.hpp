#pragma once

#include "rali/geometry/se3.hpp"

namespace rali::places {

/// Predicted pose of the source in the target, with its covariance.
struct Guess {
  geometry::SE3 T_target_source;
  geometry::Mat6 covariance = geometry::Mat6::Identity();  ///< of geometry::boxplus
};

/// Whether a pose of the source is within the guess's bounds: horizontally and in yaw, at `gate`
/// sigmas.
[[nodiscard]] bool within(const Guess& guess, const geometry::SE3& T_target_source, double gate);

/// Half sides of the bounding rectangle of all such poses, x and y [m].
[[nodiscard]] geometry::Vec2 reach_m_of(const Guess& guess, double gate);

/// Horizontal standard deviation along the worst direction [m].
[[nodiscard]] double horizontal_sigma_m(const Guess& guess);

/// Of the yaw [rad].
[[nodiscard]] double yaw_sigma_rad(const Guess& guess);

/// Yaw of T [rad]; both frames are upright.
[[nodiscard]] double yaw_of(const geometry::Mat3& R);

/// Angle brought into (-pi, pi].
[[nodiscard]] double wrapped(double angle_rad);

}  // namespace rali::places
