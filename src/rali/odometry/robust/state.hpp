#pragma once

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/odometry/side_filter.hpp"

namespace rali::odometry {

/// Error state of the filter, in this order. Rotation is perturbed on the right
/// (R Exp(theta)), gravity on its sphere, the rest additively; p and v in odom.
enum StateIndex : int {
  kTheta = 0,
  kPos = 3,
  kVel = 6,
  kGyroBias = 9,
  kAccelBias = 12,
  kGravity = 15
};

inline constexpr int kStateDim = 17;
using StateVec = Eigen::Matrix<double, kStateDim, 1>;
using StateCov = Eigen::Matrix<double, kStateDim, kStateDim>;
/// Covariance of the state with the side states.
using SideCross = Eigen::Matrix<double, kStateDim, Eigen::Dynamic, 0, kStateDim, SideStates::kMax>;

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
  geometry::Vec3 g_odom_mps2 = geometry::Vec3(0.0, 0.0, -9.81);
  StateCov P = StateCov::Zero();
  SideStates side;
  SideCross P_side = SideCross::Zero(kStateDim, 0);
};

/// Two unit vectors that with g form an orthogonal frame: tangent of the gravity sphere.
[[nodiscard]] Eigen::Matrix<double, 3, 2> gravity_basis(const geometry::Vec3& g);

/// state (+) delta; the covariance is left alone.
void add_error(FilterState& state, const StateVec& delta);

/// The error of the state develops by F; noise is added by the caller.
void propagate_covariance(FilterState& state, const StateCov& F);

/// Forgets what the state's entries [first, first + n) have to do with all else.
void decorrelate(FilterState& state, int first, int n);

/// Takes over the side states of `with`, an estimate of the same vehicle that is given up for
/// `state`: what they owe to the vehicle follows it by regression (Jeffrey's rule), all else stays.
/// Joined as they are, the two would have a covariance that no errors can have.
void carry_side_states(const FilterState& with, FilterState& state);

/// Noise of one step of propagation, already with everything that driving adds.
struct ProcessNoise {
  double gyro_radps_rthz = 0.0;
  double accel_mps2_rthz = 0.0;
  double gyro_walk = 0.0;
  double accel_walk = 0.0;
};

/// Advances state and covariance by dt_s with measured rate and specific force (bias inside).
void propagate_inertial(FilterState& state, const geometry::Vec3& gyro_radps,
                        const geometry::Vec3& accel_mps2, double dt_s, const ProcessNoise& noise);

/// Advances by dt_s at constant body velocity and rate; `accel_walk` and `gyro_walk` of the noise
/// are the white accelerations of the model [m/s^2/rtHz, rad/s^2/rtHz].
void propagate_constant_velocity(FilterState& state, double dt_s, const ProcessNoise& noise);

}  // namespace rali::odometry
