#include "rali/odometry/paper/standing.hpp"

#include <array>
#include <limits>
#include <numbers>

#include "rali/geometry/so3.hpp"

namespace rali::odometry::paper {
namespace {

/// Larger than the error of a single registration where the LiDAR constrains the pose.
constexpr double kLeaves_m = 0.1;
constexpr double kLeaves_rad = 1.0 * std::numbers::pi / 180.0;
/// This class decides whether standstill continues, so the detector may end it often. A detector
/// that keeps it longer would miss a start.
constexpr double kFalseStartsPerHour = std::numeric_limits<double>::infinity();

/// The LiDAR shows the vehicle away from its standstill pose.
bool has_left(const geometry::SE3& T_odom_body, const geometry::SE3& T_odom_body_held,
              const std::optional<geometry::Vec3>& degenerate_odom) {
  geometry::Vec3 moved_m = T_odom_body.p - T_odom_body_held.p;
  if (degenerate_odom) moved_m -= degenerate_odom->dot(moved_m) * *degenerate_odom;
  const geometry::Mat3 turned = T_odom_body_held.R.transpose() * T_odom_body.R;
  return !(moved_m.norm() < kLeaves_m && geometry::so3_log(turned).norm() < kLeaves_rad);
}

/// The local graph's estimate in the filter's order, for the IMU frame, whose samples are tested.
FilterState filter_state(Time t, const InertialGuess& guess) {
  constexpr std::array<int, 5> kOfGraph{kTheta, kVel, kPos, kGyroBias, kAccelBias};
  FilterState state;
  state.t = t;
  state.T_odom_body = {guess.state().R_odom_imu, guess.state().p_odom_m};
  state.v = guess.state().v_odom_mps;
  state.gyro_bias_radps = guess.bias().gyro_radps;
  state.accel_bias_mps2 = guess.bias().accel_mps2;
  state.g_odom_mps2 = kGravityOdom;
  const LocalGraph::Mat15& P = guess.inertial_covariance();
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      const auto row = kOfGraph[static_cast<std::size_t>(i)];
      const auto column = kOfGraph[static_cast<std::size_t>(j)];
      state.P.block<3, 3>(row, column) = P.block<3, 3>(3 * i, 3 * j);
    }
  }
  return state;
}

}  // namespace

Standing::Standing(const RobustSettings& settings, double gyro_radps_rthz)
    : detector_(settings.constraints, settings.initialisation.rest, kFalseStartsPerHour),
      gyro_radps_rthz_(gyro_radps_rthz) {}

void Standing::add(const sensor::ImuSample& sample) {
  if (!samples_.empty() && sample.t <= t_sample_) return;
  samples_.add(sample);
  t_sample_ = sample.t;
}

void Standing::learn(Time begin, Time end) {
  detector_.learn(imu::statistics(samples_.between(begin, end)));
}

bool Standing::update(Time t, const InertialGuess& guess,
                      const std::optional<geometry::Vec3>& degenerate_odom,
                      const std::optional<geometry::SE3>& T_odom_body_held) {
  if (samples_.empty()) return false;
  FilterState state = filter_state(t, guess);
  bool stands = detector_.update(state, samples_, degenerate_odom, gyro_radps_rthz_);
  if (!stands && T_odom_body_held) {
    if (degenerate_odom) state.v -= degenerate_odom->dot(state.v) * *degenerate_odom;
    stands = detector_.calm(state, samples_) &&
             !has_left(guess.T_odom_body(), *T_odom_body_held, degenerate_odom);
  }
  samples_.drop_before(t - Duration::from_s(2.0 * detector_.window_s()));
  return stands;
}

}  // namespace rali::odometry::paper
