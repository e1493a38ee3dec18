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
constexpr double kSlipSigma_mps = 0.05;
constexpr double kHeightSigmaMax_m = 0.02;
constexpr double kHeightSigma_m =
    0.06;  // one plane serves many scans: its error does not average out
constexpr double kSearchDepth_m = 2.5;

}  // namespace

void VehicleConstraints::update(FilterState& state, const Vec3& w_body_radps, const PlaneMap& map,
                                bool known, const Mat3& untouched) {
  const Vec3 v_body = state.T_odom_body.R.transpose() * state.v;
  if (known && v_body.norm() > kSpeedNeeded_mps) learn_direction(v_body);
  if (settings_.non_holonomic && non_holonomic_holds_) constrain_direction(state, w_body_radps);
  if (settings_.ground) ground(state, map, known, untouched);
}

void VehicleConstraints::learn_direction(const Vec3& v_body) {
  directions_ = kForget * directions_ + v_body * v_body.transpose() / v_body.squaredNorm();
  const geometry::Pca3 pca = geometry::pca3(directions_);
  const double weight = directions_.trace();
  non_holonomic_holds_ = weight > kWeightNeeded && pca.values[0] > kFractionNeeded * weight;
  forward_body_ = pca.vectors.col(0);
}

void VehicleConstraints::constrain_direction(FilterState& state, const Vec3& w_body_radps) {
  const Mat3& R = state.T_odom_body.R;
  const double sigma = kSlipSigma_mps + kSlipPerRate_m * w_body_radps.norm();
  const Vec3 helper = std::abs(forward_body_.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 side = helper.cross(forward_body_).normalized();
  const Vec3 up = forward_body_.cross(side);
  const Mat3 P_v = R.transpose() * state.P.block<3, 3>(kVel, kVel) * R;
  const double known_side = std::sqrt(std::max(0.0, side.dot(P_v * side)));
  const double known_up = std::sqrt(std::max(0.0, up.dot(P_v * up)));
  if (std::max(known_side, known_up) < sigma) return;  // the filter is more certain
  const Vec3 v_body = R.transpose() * state.v;
  Eigen::Matrix<double, 2, kStateDim> H = Eigen::Matrix<double, 2, kStateDim>::Zero();
  Eigen::Matrix<double, 2, 3> axes;
  axes << side.transpose(), up.transpose();
  H.block<2, 3>(0, kTheta) = axes * geometry::skew(v_body);
  H.block<2, 3>(0, kVel) = axes * R.transpose();
  const Eigen::Vector2d residual = -axes * v_body;
  const Eigen::Matrix2d noise = sigma * sigma * Eigen::Matrix2d::Identity();
  update_linear<2>(state, H, residual, noise);
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
