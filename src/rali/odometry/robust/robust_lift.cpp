#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

/// A scan at standstill, relative to whatever the LiDAR sees.
/// @param held at the last scan. @param seen_up_m by how much the LiDAR saw the pose rise
/// @return true if standstill goes on because only a force along gravity contradicts it
bool RobustOdometry::follow_lift(const FilterState& held, double seen_up_m, FindingList& findings) {
  constexpr double kUndecided_s = 2.5;
  const imu::NoiseDensity noise{rest_noise().gyro_radps_rthz, rest_noise().accel_mps2_rthz};
  const bool rode = lift_.rides();
  lift_.add(imu_.between(held.t, state_.t), held, noise.accel_mps2_rthz);
  if (lift_.stands()) {
    before_lift_ = held;
    return false;
  }
  const bool quiet = standstill_.stands_in_lift(held, state_.t, imu_, noise.gyro_radps_rthz);
  if (lift_.rides() && !rode && std::abs(seen_up_m) > 0.5 * std::abs(lift_.height().up_m)) {
    lift_.stand(state_.t);
    return false;
  }
  // Doors that close and open look like motion to the LiDAR.
  const bool goes_on = lift_.rides()
                           ? quiet || moved_scans_ < kScansToMove
                           : lift_.has_stood() && quiet && lift_.duration_s() < kUndecided_s;
  if (lift_.rides() && (lift_.is_sensor_error() || !goes_on)) {
    refuse_lift(findings);
    return false;
  }
  if (!goes_on) return false;
  // What the ride adds to the force is no bias.
  const Time now = state_.t;
  state_ = held;
  state_.t = now;
  return true;
}

/// A scan in motion. Doors that close look like motion to the LiDAR and end a standstill just
/// before the ride: while the pose stays, the force along gravity is integrated as well.
/// @return true if a ride has begun: the vehicle stands where it stood before
bool RobustOdometry::enter_lift() {
  constexpr double kDoors_m = 0.15;  // what doors do to the pose
  constexpr double kStill_rad = 0.02;
  const imu::NoiseDensity noise{rest_noise().gyro_radps_rthz, rest_noise().accel_mps2_rthz};
  const geometry::Vec6 moved = geometry::boxminus(before_lift_.T_odom_body, state_.T_odom_body);
  // The cheap tests first: most scans of a drive end here.
  if (moved.tail<3>().norm() > kDoors_m || moved.head<3>().norm() > kStill_rad ||
      !standstill_.stands_in_lift(before_lift_, state_.t, imu_, noise.gyro_radps_rthz)) {
    lift_.stand(state_.t);
    before_lift_ = state_;
    return false;
  }
  lift_.add(imu_.between(last_posterior_.t, state_.t), before_lift_, noise.accel_mps2_rthz);
  if (lift_.stands()) before_lift_ = state_;
  if (!lift_.rides()) return false;
  const FilterState now = state_;
  state_ = before_lift_;
  state_.t = now.t;
  carry_augmented_states(now, state_);
  state_.v.setZero();
  decorrelate(state_, kVel, 3);
  constexpr double kSigma_mps = 0.01;
  state_.P.diagonal().segment<3>(kVel).setConstant(kSigma_mps * kSigma_mps);
  at_standstill_ = true;
  moved_scans_ = 0;
  standstill_states_.clear();
  motion_noise_.interrupt();
  acceleration_.reset();
  standstill_.stood_since(state_.t, state_.T_odom_body);
  return true;
}

/// @param height of the ride
Finding RobustOdometry::lift_finding(const LiftRide::Height& height) const {
  Finding f;
  f.id = "odometry.lift";
  f.severity = Severity::kWarning;
  f.t = lift_.begin();
  f.t_end = state_.t;
  f.text = fmt::format(
      "a lift: for {:.0f} s the accelerometer felt a ride of {:.2f} m {} while the LiDAR saw "
      "nothing move",
      lift_.duration_s(), std::abs(height.up_m), height.up_m > 0.0 ? "up" : "down");
  f.effect = fmt::format("the height from there on is by the accelerometer, to {:.2f} m (1 sigma)",
                         height.sigma_m);
  return f;
}

/// The cabin has arrived: the pose moves with it, and the cabin enters the map there.
void RobustOdometry::arrive(const LidarScan& scan, FindingList& findings) {
  const LiftRide::Height height = lift_.height();
  const Vec3 up = -state_.g_odom_mps2.normalized();
  findings.push_back(lift_finding(height));
  state_.T_odom_body.p += height.up_m * up;
  widen_position(height.sigma_m * height.sigma_m * up * up.transpose());
  standstill_states_.clear();
  standstill_.stood_since(state_.t, state_.T_odom_body);
  last_posterior_ = state_;
  ScanMotion(calibration_.T_body_lidar).apply(scan, sampler_.insert_indices(), points_);
  insert_points(state_.T_odom_body);
  cover_.show(points_, state_.T_odom_body);
  lift_.stand(state_.t);
}

/// A force that never ended is an error of the sensor. If the vehicle drives on before it ended,
/// nobody knows.
void RobustOdometry::refuse_lift(FindingList& findings) {
  const LiftRide::Height height = lift_.height();
  const bool sensor = lift_.is_sensor_error();
  Finding f;
  f.id = "odometry.contradiction";
  f.severity = Severity::kWarning;
  f.t = lift_.begin();
  f.t_end = state_.t;
  f.text = fmt::format(
      "at standstill the accelerometer felt a vertical speed of {:.1f} m/s that did not end: {}",
      lift_.speed_mps(), sensor ? "its error has changed" : "a lift, or an error of the sensor");
  f.effect = "the height is taken to be unchanged";
  if (!sensor) {
    const Vec3 up = -state_.g_odom_mps2.normalized();
    widen_position(height.up_m * height.up_m * up * up.transpose());
  }
  state_.P.block<3, 3>(kAccelBias, kAccelBias) +=
      std::pow(lift_.speed_mps() / lift_.duration_s(), 2) * Mat3::Identity();
  findings.push_back(f);
  lift_.stand(state_.t);
}

/// The result of a scan, with the ride so far. @param span_s since the last one
ScanResult RobustOdometry::riding(const LidarScan& scan, const UpdateResult& seen, double span_s) {
  const SE3 T_before = T_reported_;
  ScanResult result = result_of(scan, seen);
  const Vec3 up = -state_.g_odom_mps2.normalized();
  if (lift_.rides()) {
    const LiftRide::Height height = lift_.height();
    result.T_odom_body.p += height.up_m * up;
    result.T_last_predicted.p =
        state_.T_odom_body.R.transpose() * (span_s * lift_.speed_mps() * up);
    result.v_odom_mps = lift_.speed_mps() * up;
    result.covariance.bottomRightCorner<3, 3>() +=
        height.sigma_m * height.sigma_m * up * up.transpose();
  }
  result.at_rest = !lift_.rides();
  result.T_odom_body_predicted = T_before * result.T_last_predicted;
  T_reported_ = result.T_odom_body;
  return result;
}

}  // namespace rali::odometry::internal
