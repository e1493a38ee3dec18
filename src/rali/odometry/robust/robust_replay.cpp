#include <cmath>
#include <span>

#include "rali/odometry/robust/internal/start_memory.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Vec3;
using sensor::LidarScan;

RobustOdometry::StartMemory RobustOdometry::start_memory() const {
  return {state_,
          last_posterior_,
          map_,
          drift_,
          constraints_,
          refusal_,
          axes_,
          lidar_known_,
          degenerate_,
          bend_,
          seeing_scans_,
          t_degenerate_,
          t_speed_bounded_,
          t_seen_,
          fastest_seen_mps_,
          usual_fit_,
          noise_boost_,
          scans_in_map_,
          sampler_};
}

void RobustOdometry::take(const StartMemory& memory) {
  state_ = memory.state;
  last_posterior_ = memory.last_posterior;
  map_ = memory.map;
  drift_ = memory.drift;
  constraints_ = memory.constraints;
  refusal_ = memory.refusal;
  axes_ = memory.axes;
  lidar_known_ = memory.lidar_known;
  degenerate_ = memory.degenerate;
  bend_ = memory.bend;
  seeing_scans_ = memory.seeing_scans;
  t_degenerate_ = memory.t_degenerate;
  t_speed_bounded_ = memory.t_speed_bounded;
  t_seen_ = memory.t_seen;
  fastest_seen_mps_ = memory.fastest_seen_mps;
  usual_fit_ = memory.usual_fit;
  noise_boost_ = memory.noise_boost;
  scans_in_map_ = memory.scans_in_map;
  sampler_ = memory.sampler;
}

/// Sets gravity from the mean force of `span_s`, with a sigma for the vehicle's acceleration in it.
void RobustOdometry::level_start(const Vec3& g_odom_mps2, double span_s, FilterState& begin) const {
  const double bias = settings_.initialisation.accel_bias_sigma_mps2;
  const double tilt = mean_force_sigma_mps2(span_s) / settings_.initialisation.gravity_mps2;
  begin.g_odom_mps2 = g_odom_mps2;
  begin.accel_bias_mps2.setZero();
  decorrelate(begin, kAccelBias, 5);
  begin.P.diagonal().segment<3>(kAccelBias).setConstant(bias * bias);
  begin.P.diagonal().segment<2>(kGravity).setConstant(tilt * tilt);
  begin_tilt(begin, tilt_rate());
}

/// Replays the first scans from the first pose on, at a given first speed.
FirstSpeedFit RobustOdometry::replay(std::span<const LidarScan> scans, const FirstSpeed& first,
                                     FindingList& findings) {
  FilterState begin = state_;
  begin.t = scans.front().t_end;
  begin.T_odom_body = track_.front().T_odom_body;
  begin.v = first.v_odom_mps;
  decorrelate(begin, kTheta, kGyroBias);
  begin.P.topLeftCorner<6, 6>() = 1e-10 * geometry::Mat6::Identity();
  begin.P.diagonal().segment<3>(kVel).setConstant(first.sigma_mps * first.sigma_mps);
  if (first.g_odom_mps2) {
    level_start(*first.g_odom_mps2, seconds_between(begin.t, scans.back().t_end), begin);
  }
  state_ = begin;
  map_ = PlaneMap(settings_.map);
  scans_in_map_ = 0;
  drift_.establish_all();
  insert_at_constant_speed(scans.front(), gyro_rate(scans.front().t_start, scans.front().t_end));
  const Vec3 ahead = begin.T_odom_body.R * forward_body_;
  FirstSpeedFit fit;
  for (const LidarScan& scan : scans.subspan(1)) {
    poses_.clear();
    sampler_.sample(scan);
    predict(scan.t_end);
    const UpdateResult done = update(scan, 1);
    remember_seen(done);
    add_fit(scan, done, ahead, fit);
    constrain(done, findings);
    if (done.matches >= settings_.update.matches_min || scans_in_map_ < kYoungScans) insert(scan);
    last_posterior_ = state_;
    if (&scan == &scans.back()) break;  // its covariance is computed with its result
    covariance(done);                   // the map's error grows along the path
    drift_.establish_all();
  }
  const double n = static_cast<double>(scans.size() - 1);
  for (double* sum : {&fit.nis, &fit.sideways, &fit.on_walls, &fit.on_facing}) *sum /= n;
  fit.speed_sigma_mps = std::sqrt(ahead.dot(state_.P.block<3, 3>(kVel, kVel) * ahead));
  fit.mean_mps =
      ahead.dot(state_.T_odom_body.p - begin.T_odom_body.p) / seconds_between(begin.t, state_.t);
  return fit;
}

/// No motion is known before the first scan: its own is taken as constant.
void RobustOdometry::insert_at_constant_speed(const LidarScan& scan,
                                              const std::optional<Vec3>& gyro_radps) {
  poses_at_constant_speed(scan, gyro_radps);
  sampler_.sample(scan);
  insert(scan);
}

/// The path within a scan, if speed and turn rate are constant. Empty rate: no turn.
void RobustOdometry::poses_at_constant_speed(const LidarScan& scan,
                                             const std::optional<Vec3>& gyro_radps) {
  constexpr int kSteps = 10;
  const double span_s = (scan.t_end - scan.t_start).s();
  const Vec3 w = gyro_radps ? Vec3(*gyro_radps - state_.gyro_bias_radps) : Vec3::Zero();
  poses_.clear();
  for (int k = 0; k <= kSteps; ++k) {
    const double ago_s = span_s * (kSteps - k) / kSteps;
    const Mat3 R = state_.T_odom_body.R * geometry::so3_exp(-ago_s * w);
    poses_.push_back(
        {scan.t_end - Duration::from_s(ago_s), {R, state_.T_odom_body.p - ago_s * state_.v}});
  }
}

}  // namespace rali::odometry::internal
