#pragma once

#include <array>
#include <string>

#include "rali/config/field.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::config {

/// The pose of a sensor in the body, as the user gave it.
struct Extrinsics {
  enum class Source { kAuto, kGiven, kFromTf };
  Source source = Source::kAuto;
  geometry::SE3 T;       ///< T_body_sensor, valid if kGiven
  std::string tf_frame;  ///< the sensor's frame in /tf_static, if kFromTf
  std::string form;      ///< the user's own notation, so that a dump reads back to the same bits
};

/// {xyz_m, rpy_deg | quat_xyzw | matrix} or {from_tf: FRAME}, or `auto` where that is allowed.
/// Errors (kUsage): two rotations, a quaternion that is not of unit length, a matrix that is not
/// orthonormal or mirrors (determinant -1), from_tf with anything else.
[[nodiscard]] CustomTarget extrinsics_target(Extrinsics& extrinsics, bool auto_allowed);

/// "0.08 m forward, 0.25 m up of the IMU, turned 1.5 deg left": a pose as text.
[[nodiscard]] std::string pose_in_words(const geometry::SE3& T_body_sensor);

}  // namespace rali::config
