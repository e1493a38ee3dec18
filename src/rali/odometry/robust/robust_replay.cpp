#include "rali/odometry/robust/internal/robust_filter.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Vec3;
using sensor::LidarScan;

/// A vehicle that drove when the recording began: its first scans were undistorted and registered
/// without knowing how it moved. Now that speed, gravity and biases are known, they are gone
/// through once more, and the map is free of what the first second got wrong. The first pose stays.
/// Should scans and prediction disagree on that way, something was felt that was no motion: all
/// stays as it was.
void RobustOdometry::replay_start(const InitialGuess& guess, FindingList& findings) {
  constexpr double kHonestNis = 6.0;  // of six degrees of freedom
  if (start_scans_.size() < 2) return;
  const std::vector<LidarScan> scans = std::move(start_scans_);
  start_scans_.clear();
  const FilterState state_before = state_;
  const PlaneMap map_before = map_;
  const int scans_before = scans_in_map_;
  FilterState begin = state_;
  begin.t = scans.front().t_end;
  begin.T_odom_body = track_.front().T_odom_body;
  begin.v = guess.v_first_mps;
  decorrelate(begin, kTheta, kGyroBias);
  begin.P.topLeftCorner<6, 6>() = 1e-10 * geometry::Mat6::Identity();
  begin.P.diagonal().segment<3>(kVel).setConstant(guess.v_first_sigma_mps *
                                                  guess.v_first_sigma_mps);
  state_ = begin;
  map_ = PlaneMap(settings_.map);
  scans_in_map_ = 0;
  drift_.establish_all();
  insert_at_constant_speed(scans.front(), gyro_rate(scans.front().t_begin, scans.front().t_end));
  double nis = 0.0;
  for (std::size_t k = 1; k < scans.size(); ++k) {
    poses_.clear();
    sampler_.sample(scans[k]);
    predict(scans[k].t_end);
    const UpdateResult done = update(scans[k], 1);
    nis += done.nis / static_cast<double>(scans.size() - 1);
    constrain(done, findings);
    if (done.matches >= settings_.update.matches_min || scans_in_map_ < kYoungScans) {
      insert(scans[k]);
    }
    last_posterior_ = state_;
  }
  if (nis < kHonestNis) return;
  state_ = state_before;
  map_ = map_before;
  scans_in_map_ = scans_before;
}

/// The first scan has no motion before it: its own is taken for constant.
void RobustOdometry::insert_at_constant_speed(const LidarScan& scan,
                                              const std::optional<Vec3>& gyro_radps) {
  constexpr int kSteps = 10;
  const double span_s = (scan.t_end - scan.t_begin).s();
  const Vec3 w = gyro_radps ? Vec3(*gyro_radps - state_.gyro_bias_radps) : Vec3::Zero();
  poses_.clear();
  for (int k = 0; k <= kSteps; ++k) {
    const double ago_s = span_s * (kSteps - k) / kSteps;
    const Mat3 R = state_.T_odom_body.R * geometry::so3_exp(-ago_s * w);
    poses_.push_back(
        {scan.t_end - Duration::from_s(ago_s), {R, state_.T_odom_body.p - ago_s * state_.v}});
  }
  sampler_.sample(scan);
  insert(scan);
}

}  // namespace rali::odometry::internal
