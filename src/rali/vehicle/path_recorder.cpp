#include "rali/vehicle/path_recorder.hpp"

#include <algorithm>
#include <numbers>

#include "rali/vehicle/inertial_factor.hpp"

namespace rali::vehicle {

void PathRecorder::add(const sensor::ImuSample& sample) {
  // Without an earlier node only the last samples can be needed.
  constexpr std::size_t kSamplesMax = 100'000;
  if (imu_.size() >= kSamplesMax) imu_.erase(imu_.begin(), imu_.begin() + kSamplesMax / 2);
  imu_.push_back(sample);
}

bool PathRecorder::wants(const odometry::ScanResult& result, bool keyframe) const {
  if (!last_ || keyframe || result.at_rest != last_at_rest_) return true;
  const double waited_s = (result.t - *last_).s();
  return waited_s >= (result.at_rest ? settings_.path.rest_s : settings_.path.drive_s);
}

std::optional<PathNode> PathRecorder::add(const odometry::ScanResult& result,
                                          const std::optional<KeyframeId>& keyframe,
                                          bool degenerate, const geometry::Vec3& g_odom_mps2,
                                          double level_sigma_rad) {
  if (last_ && result.t <= *last_) return std::nullopt;
  if (!wants(result, keyframe.has_value())) return std::nullopt;
  PathNode node;
  node.t = result.t;
  fleet::Increment& step = node.step;
  step.node = nodes_++;
  if (keyframe) step.keyframe = keyframe->seq;
  step.begins = !last_;
  step.at_rest = result.at_rest;
  step.degenerate = degenerate;
  step.levelled = result.inertial;
  step.T_odom_body = result.T_odom_body;
  step.v_odom_mps = result.v_odom_mps;
  step.gyro_bias_radps = result.gyro_bias_radps;
  step.accel_bias_mps2 = result.accel_bias_mps2;
  step.force_sigma_mps2 = result.force_sigma_mps2;
  step.g_odom_mps2 = g_odom_mps2;
  // A fact with a number out of bounds would be refused, and the path would lose this node.
  step.level_sigma_rad = level_sigma_rad < std::numbers::pi ? level_sigma_rad : std::numbers::pi;
  step.covariance = result.covariance;
  step.lidar_information = result.lidar_information;
  if (last_ && result.inertial) {
    step.inertial = preintegrate(*last_, node.t, {result.gyro_bias_radps, result.accel_bias_mps2},
                                 result.inertial_noise);
  }
  const auto used = std::find_if(imu_.begin(), imu_.end(),
                                 [&](const sensor::ImuSample& s) { return s.t > node.t; });
  // One sample before the node stays: it is valid until the next.
  if (used != imu_.begin()) imu_.erase(imu_.begin(), used - 1);
  last_ = node.t;
  last_at_rest_ = result.at_rest;
  return node;
}

std::optional<graph::InertialFactor> PathRecorder::preintegrate(
    Time from, Time to, const imu::InertialBias& bias, const imu::NoiseDensity& noise) const {
  imu::Preintegration sum(bias, {noise.gyro_radps_rthz, noise.accel_mps2_rthz});
  const double span_s = (to - from).s();
  if (sum.add_stream(imu_, from, to) < 0.9 * span_s) return std::nullopt;
  return inertial_factor(sum, settings_.odometry.imu_noise, settings_.calibration.T_body_imu);
}

}  // namespace rali::vehicle
