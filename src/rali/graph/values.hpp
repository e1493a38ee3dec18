#pragma once

#include <cstdint>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::graph {

/// Tangent of a keyframe, in this order (as the filter of module odometry, without gravity).
enum StateIndex : int { kTheta = 0, kPos = 3, kVel = 6, kGyroBias = 9, kAccelBias = 12 };

inline constexpr int kPoseDim = 6;
inline constexpr int kStateDim = 15;
using StateVec = Eigen::Matrix<double, kStateDim, 1>;
using StateMat = Eigen::Matrix<double, kStateDim, kStateDim>;

/// Estimated state of one keyframe. In a PoseGraph the frame `odom` of the names is map. The
/// velocity is that of the accelerometer's position.
struct KeyframeState {
  geometry::SE3 T_odom_body;
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();
};

/// Pose by geometry::boxplus, the rest by addition.
[[nodiscard]] KeyframeState boxplus(const KeyframeState& x, const StateVec& delta);

/// The delta with boxplus(a, delta) = b.
[[nodiscard]] StateVec boxminus(const KeyframeState& b, const KeyframeState& a);

/// d boxminus(boxplus(b, e), a)/de at e = 0, where delta = boxminus(b, a): the identity but for the
/// rotation.
[[nodiscard]] StateMat boxminus_jacobian(const StateVec& delta);

/// Variables estimated once and not per keyframe.
enum class GlobalKind : std::uint8_t {
  kLandmark,  ///< antenna of a peer at standstill, position in odom [m]
  kBias,      ///< range bias of a pair of antennas [m]
  kTau        ///< time offset of a radio: the range is that of `tau` later [s]
};

/// Number of a landmark, bias or tau, given by the caller; each kind has its own numbers.
struct GlobalId {
  GlobalKind kind = GlobalKind::kLandmark;
  int number = 0;
  constexpr auto operator<=>(const GlobalId&) const = default;
};

[[nodiscard]] inline GlobalId landmark_id(int number) { return {GlobalKind::kLandmark, number}; }

[[nodiscard]] inline GlobalId bias_id(int number) { return {GlobalKind::kBias, number}; }

[[nodiscard]] inline GlobalId tau_id(int number) { return {GlobalKind::kTau, number}; }

[[nodiscard]] constexpr int dimension(GlobalKind kind) {
  return kind == GlobalKind::kLandmark ? 3 : 1;
}

}  // namespace rali::graph
