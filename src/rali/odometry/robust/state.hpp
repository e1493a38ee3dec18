#pragma once

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/odometry/augmented_filter.hpp"

namespace rali::odometry {

/// Error state of the filter, in this order. Rotation is perturbed on the right
/// (R Exp(theta)), gravity on its sphere, the rest additively; p and v in odom.
/// Gravity where the vehicle is and at its first pose differ by the tilt of the map (map_tilt.hpp).
enum StateIndex : int {
  kTheta = 0,
  kPos = 3,
  kVel = 6,
  kGyroBias = 9,
  kAccelBias = 12,
  kGravity = 15,
  kFirstGravity = 17,
  kTiltRate = 19
};

inline constexpr int kStateDim = 20;
using StateVec = Eigen::Matrix<double, kStateDim, 1>;
using StateCov = Eigen::Matrix<double, kStateDim, kStateDim>;
/// Covariance of the state with the augmented states.
using AugmentedCross =
    Eigen::Matrix<double, kStateDim, Eigen::Dynamic, 0, kStateDim, AugmentedStates::kMax>;

/// State of the filter at time t.
///
/// With inertial data: pose, velocity in odom, biases, gravity. Without: `v` is the velocity in
/// the *body* frame and `gyro_bias` holds the body's angular rate [rad/s] (constant velocity
/// model, algorithms 2.7); accelerometer bias and gravity are unused.
struct FilterState {
  Time t;
  geometry::SE3 T_odom_body;
  geometry::Vec3 v = geometry::Vec3::Zero();
  geometry::Vec3 gyro_bias_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_bias_mps2 = geometry::Vec3::Zero();
  geometry::Vec3 g_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);        ///< where the vehicle is
  geometry::Vec3 g_first_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);  ///< at the first pose
  double tilt_radpm = 0.0;  ///< turn of gravity in odom for each metre driven
  StateCov P = StateCov::Zero();
  AugmentedStates augmented;
  AugmentedCross P_augmented = AugmentedCross::Zero(kStateDim, 0);
};

/// Two unit vectors that form an orthogonal frame with g: tangent of the gravity sphere.
[[nodiscard]] Eigen::Matrix<double, 3, 2> gravity_basis(const geometry::Vec3& g);

/// state (+) delta; the covariance is unchanged.
void add_error(FilterState& state, const StateVec& delta);

/// Propagates the covariance by F; the caller adds noise.
void propagate_covariance(FilterState& state, const StateCov& F);

/// Removes the correlation of the state's entries [first, first + n) with all others.
void decorrelate(FilterState& state, int first, int n);

/// Sigma of the specific force expected at constant speed, in its worst direction: of accelerometer
/// bias and gravity together, which are known better than each of them.
/// @param state with inertial data
[[nodiscard]] double force_sigma_mps2(const FilterState& state);

/// Copies the augmented states of `with`, an estimate of the same vehicle that `state` replaces.
/// Their dependence on the vehicle follows by regression (Jeffrey's rule); the rest is unchanged.
/// Simply copied, the joint covariance could be indefinite.
void carry_augmented_states(const FilterState& with, FilterState& state);

/// Noise of one step of propagation, including everything that driving adds.
struct ProcessNoise {
  double gyro_radps_rthz = 0.0;
  double accel_mps2_rthz = 0.0;
  double gyro_walk = 0.0;
  double accel_walk = 0.0;
};

/// Advances state and covariance by dt_s with measured rate and specific force (bias included).
void propagate_inertial(FilterState& state, const geometry::Vec3& gyro_radps,
                        const geometry::Vec3& accel_mps2, double dt_s, const ProcessNoise& noise);

/// Advances by dt_s at constant body velocity and rate; `accel_walk` and `gyro_walk` of the noise
/// are the white accelerations of the model [m/s^2/rtHz, rad/s^2/rtHz].
void propagate_constant_velocity(FilterState& state, double dt_s, const ProcessNoise& noise);

}  // namespace rali::odometry
