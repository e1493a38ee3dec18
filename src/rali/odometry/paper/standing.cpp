#include "rali/odometry/paper/standing.hpp"

namespace rali::odometry::paper {

Standing::Standing(const RobustSettings& settings, double gyro_radps_rthz)
    : detector_(settings.constraints, settings.initialisation.rest),
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
                      const std::optional<geometry::Vec3>& degenerate_odom) {
  if (samples_.empty()) return false;
  FilterState state;
  state.t = t;
  state.T_odom_body = guess.T_odom_body();
  state.v = guess.motion().v_odom_imu_mps;
  state.gyro_bias_radps = guess.bias().gyro_radps;
  const geometry::Mat6 motion = guess.motion_covariance();
  state.P.block<3, 3>(kVel, kVel) = motion.topLeftCorner<3, 3>();
  state.P.block<3, 3>(kGyroBias, kGyroBias) = motion.bottomRightCorner<3, 3>();
  const bool stands = detector_.update(state, samples_, degenerate_odom, gyro_radps_rthz_);
  samples_.drop_before(t - Duration::from_s(2.0 * detector_.window_s()));
  return stands;
}

}  // namespace rali::odometry::paper
