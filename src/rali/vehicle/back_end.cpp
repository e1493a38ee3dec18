#include "rali/vehicle/back_end.hpp"

#include <algorithm>

#include "rali/vehicle/inertial_factor.hpp"

namespace rali::vehicle {

using geometry::Vec3;

BackEnd::BackEnd(VehicleId self, const VehicleSettings& settings)
    : self_(self), settings_(settings) {}

void BackEnd::add(const sensor::ImuSample& sample) {
  if (!settings_.back_end.use) return;
  // Without a node to begin from only the last samples can be needed.
  constexpr std::size_t kSamplesMax = 100'000;
  if (imu_.size() >= kSamplesMax) imu_.erase(imu_.begin(), imu_.begin() + kSamplesMax / 2);
  imu_.push_back(sample);
}

bool BackEnd::wants_node(const odometry::ScanResult& result, bool keyframe) const {
  if (nodes_.empty() || keyframe) return true;
  const Node& last = nodes_.back();
  if (result.at_rest != last.at_rest) return true;
  const double waited_s = (result.t - last.t).s();
  return waited_s >= (result.at_rest ? settings_.back_end.rest_s : settings_.back_end.drive_s);
}

void BackEnd::add(const odometry::ScanResult& result, const std::optional<KeyframeId>& keyframe,
                  bool blind, const std::vector<RangeRecord>& ranges) {
  if (!settings_.back_end.use || !result.inertial) return;
  if (!nodes_.empty() && result.t <= nodes_.back().t) return;
  if (!nodes_.empty()) {
    for (const RangeRecord& r : ranges) ranges_.push_back({r, nodes_.size() - 1});
  }
  if (wants_node(result, keyframe.has_value())) add_node(result, keyframe, blind);
}

void BackEnd::add_node(const odometry::ScanResult& result,
                       const std::optional<KeyframeId>& keyframe, bool blind) {
  Node node;
  node.t = result.t;
  node.keyframe = keyframe;
  node.T_filter = result.T_odom_body;
  node.v_odom_mps = result.v_odom_mps;
  node.gyro_bias_radps = result.gyro_bias_radps;
  node.accel_bias_mps2 = result.accel_bias_mps2;
  node.covariance = result.covariance;
  node.information = result.lidar_information;
  node.at_rest = result.at_rest;
  if (blind && !nodes_.empty()) {
    blind_m_ += (node.T_filter.p - nodes_.back().T_filter.p).norm();
  }
  if (!nodes_.empty()) node.inertial = preintegrate(nodes_.back().t, node.t, node);
  const auto used = std::find_if(imu_.begin(), imu_.end(),
                                 [&](const sensor::ImuSample& s) { return s.t > node.t; });
  // One sample before the node stays: it holds until the next.
  if (used != imu_.begin()) imu_.erase(imu_.begin(), used - 1);
  nodes_.push_back(std::move(node));
}

std::optional<graph::InertialFactor> BackEnd::preintegrate(Time from, Time to,
                                                           const Node& node) const {
  const odometry::ImuNoiseSettings& n = settings_.odometry.imu_noise;
  const imu::InertialBias bias{node.gyro_bias_radps, node.accel_bias_mps2};
  imu::Preintegration sum(
      bias, {n.gyro_radps_rthz * n.vibration_factor, n.accel_mps2_rthz * n.vibration_factor});
  const double span_s = (to - from).s();
  if (sum.add_stream(imu_, from, to) < 0.9 * span_s) return std::nullopt;
  return inertial_factor(sum, n, settings_.calibration.T_body_imu);
}

void BackEnd::forget() {
  nodes_.clear();
  ranges_.clear();
  blind_m_ = 0.0;
}

}  // namespace rali::vehicle
