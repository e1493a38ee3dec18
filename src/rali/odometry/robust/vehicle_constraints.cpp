#include "rali/odometry/robust/vehicle_constraints.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "rali/geometry/pca3.hpp"
#include "rali/odometry/robust/update.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Vec3;

namespace {

constexpr double kForget = 0.99;           // memory of 100 scans
constexpr double kWeightNeeded = 40.0;     // scans before a constraint is used
constexpr double kSpeedNeeded_mps = 0.3;   // slower motion has no direction
constexpr double kFractionNeeded = 0.995;  // of motion along one body direction: within 4 degrees
constexpr double kUnseen = 0.5;            // square of the cosine: within 45 degrees
constexpr double kClimbMax = 0.15;         // rms; feet and hands sway by more
constexpr double kSlipSigma_mps = 0.05;
constexpr double kClimbSigma_mps = 0.01;  // of a vehicle that turns on the spot
constexpr double kHeightSigmaMax_m = 0.02;
constexpr double kHeightSigma_m =
    0.06;  // one plane serves many scans: its error does not average out
constexpr double kSearchDepth_m = 2.5;

/// The unit vector nearest to `up` at right angles to `forward`.
Vec3 across(const Vec3& forward, const Vec3& up) {
  const Vec3 level = up - up.dot(forward) * forward;
  return level.norm() > 0.1 ? level.normalized() : forward.unitOrthogonal();
}

/// No speed along an axis of the body, by `sigma_mps`; nothing where the filter is more certain.
void constrain_speed(FilterState& state, const Vec3& axis_body, double sigma_mps) {
  const Mat3& R = state.T_odom_body.R;
  const Vec3 axis = R * axis_body;
  if (axis.dot(state.P.block<3, 3>(kVel, kVel) * axis) < sigma_mps * sigma_mps) return;
  const Vec3 v_body = R.transpose() * state.v;
  Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
  H.segment<3>(kTheta) = axis_body.transpose() * geometry::skew(v_body);
  H.segment<3>(kVel) = axis.transpose();
  update_linear<1>(state, H, Eigen::Matrix<double, 1, 1>(-axis_body.dot(v_body)),
                   Eigen::Matrix<double, 1, 1>(sigma_mps * sigma_mps));
}

}  // namespace

void VehicleConstraints::update(FilterState& state, const Vec3& w_body_radps, const PlaneMap& map,
                                bool known, const Mat3& untouched) {
  const Mat3& R = state.T_odom_body.R;
  const Vec3 v_body = R.transpose() * state.v;
  const Vec3 up_body = -(R.transpose() * state.g_odom_mps2).normalized();
  if (known && v_body.norm() > kSpeedNeeded_mps) learn_direction(v_body, up_body);
  if (settings_.non_holonomic) {
    const Vec3 up = across(forward_body_, up_body);
    constrain_sideways(state, w_body_radps, up);
    const Vec3 up_odom = R * up;
    if (up_odom.dot(untouched * up_odom) > kUnseen) constrain_climb(state, w_body_radps, up);
  }
  if (settings_.ground) ground(state, map, known, untouched);
}

void VehicleConstraints::learn_direction(const Vec3& v_body, const Vec3& up_body) {
  directions_ = kForget * directions_ + v_body * v_body.transpose() / v_body.squaredNorm();
  const geometry::Pca3 pca = geometry::pca3(directions_);
  const double weight = directions_.trace();
  non_holonomic_holds_ = weight > kWeightNeeded && pca.values[0] > kFractionNeeded * weight;
  forward_body_ = pca.vectors.col(0);
  const Vec3 up = across(forward_body_, up_body);
  climb_ = std::sqrt(std::max(0.0, up.dot(directions_ * up)) / weight);
  on_ground_ = weight > kWeightNeeded && climb_ < kClimbMax;
}

/// A turn moves the sensor sideways, since it is not above the axle.
void VehicleConstraints::constrain_sideways(FilterState& state, const Vec3& w_body_radps,
                                            const Vec3& up) const {
  if (!non_holonomic_holds_) return;
  const double sigma_mps = kSlipSigma_mps + kSlipPerRate_m * w_body_radps.norm();
  constrain_speed(state, up.cross(forward_body_), sigma_mps);
}

/// Only rolling and pitching move the sensor off the ground, and driving over what is uneven. A
/// scan that observes the height measures this better.
void VehicleConstraints::constrain_climb(FilterState& state, const Vec3& w_body_radps,
                                         const Vec3& up) const {
  if (!on_ground_) return;
  const Mat3& R = state.T_odom_body.R;
  const Mat3 level = Mat3::Identity() - up * up.transpose();
  const Mat3 P_level = level * R.transpose() * state.P.block<3, 3>(kVel, kVel) * R * level;
  const double speed2 = (level * R.transpose() * state.v).squaredNorm() + P_level.trace();
  const double rocking = kSlipPerRate_m * (level * w_body_radps).norm();
  constrain_speed(state, up, kClimbSigma_mps + climb_ * std::sqrt(speed2) + rocking);
}

/// The normal of a plane is wrong by degrees. Along a tunnel, where the position may be uncertain
/// by metres, such a plane would look like a slope and measure it: so that part is left out.
void VehicleConstraints::ground(FilterState& state, const PlaneMap& map, bool known,
                                const Mat3& untouched) {
  const Vec3 up = -state.g_odom_mps2.normalized();
  int index = -1;
  // The first upward plane straight below the sensor.
  const double step_m = 0.25 * map.settings().voxel_m;
  for (double depth = 0.0; depth < kSearchDepth_m && index < 0; depth += step_m) {
    const int found = map.find(state.T_odom_body.p - depth * up);
    if (found >= 0 && std::abs(map.plane(found).n.dot(up)) > 0.95) index = found;
  }
  if (index < 0) return;
  const Plane& plane = map.plane(index);
  const Vec3 n = plane.n.dot(up) > 0.0 ? plane.n : Vec3(-plane.n);
  const double height_m = n.dot(state.T_odom_body.p - plane.q);
  if (known) {
    if (height_weight_ == 0.0)
      height_m_ = height_m;  // otherwise the first height would count as spread
    height_weight_ = kForget * height_weight_ + 1.0;
    const double difference = height_m - height_m_;
    height_m_ += difference / height_weight_;
    height_var_m2_ += (difference * difference - height_var_m2_) / height_weight_;
  }
  ground_holds_ =
      height_weight_ > kWeightNeeded && height_var_m2_ < kHeightSigmaMax_m * kHeightSigmaMax_m;
  const Vec3 across = n - untouched * n;
  const double sigma_z = std::sqrt(across.dot(state.P.block<3, 3>(kPos, kPos) * across));
  if (!ground_holds_ || sigma_z < kHeightSigma_m) return;
  Eigen::Matrix<double, 1, kStateDim> H = Eigen::Matrix<double, 1, kStateDim>::Zero();
  H.block<1, 3>(0, kPos) = across.transpose();
  const Eigen::Matrix<double, 1, 1> residual{height_m_ - height_m};
  const Eigen::Matrix<double, 1, 1> noise{kHeightSigma_m * kHeightSigma_m + plane.var_offset};
  update_linear<1>(state, H, residual, noise);
}

}  // namespace rali::odometry
