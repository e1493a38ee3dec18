#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"
#include "rali/odometry/robust/wide_search.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

/// In this time a vehicle can stop, start and turn: the samples before and after an interruption
/// do not determine the motion in between.
constexpr double kUnknown_s = 1.0;
/// Farther than this a vehicle is not looked for: too many places look alike.
constexpr double kReachMax_m = 20.0;
constexpr double kReachSigmas = 2.0;

/// Of the heading after an interruption; beyond half a turn it is unknown.
double turn_sigma_rad(double gap_s) {
  constexpr double kTurn_radps = 0.3;
  return std::min(kTurn_radps * gap_s, std::numbers::pi / std::numbers::sqrt3);
}

bool are_apart(const SE3& a, const SE3& b) {
  constexpr double kApart_m = 0.5;
  constexpr double kApart_rad = 0.17;
  return (a.p - b.p).norm() > kApart_m ||
         geometry::so3_log(a.R.transpose() * b.R).norm() > kApart_rad;
}

}  // namespace

/// Since the last scan, inertial data are missing for so long that the motion is unknown.
bool RobustOdometry::is_interrupted(Time t_end) const {
  return inertial_ && !imu_.empty() && seconds_between(last_posterior_.t, t_end) > kUnknown_s &&
         imu_.longest_gap_s(last_posterior_.t, t_end) > kUnknown_s;
}

/// The last state, moved by a velocity that is forgotten (Ornstein-Uhlenbeck process: correlation
/// time tau, sd sigma): soon after, the vehicle drives on as before; later it may have stopped,
/// turned or started. Biases and gravity stay as they are.
FilterState RobustOdometry::anywhere_reached(Time t) const {
  constexpr double kTau_s = 10.0;
  constexpr double kTilt_rad = 0.1;
  const double gap_s = seconds_between(last_posterior_.t, t);
  // Between standing still and the usual speed in any direction.
  const double sigma_mps = 0.5 * std::max(settings_.constraints.speed_usual_mps, fastest_seen_mps_);
  const double kept = std::exp(-gap_s / kTau_s);
  const double forgotten_s = kTau_s * (1.0 - kept);
  // Ranges may have added or removed augmented states since the last scan.
  FilterState out = state_;
  out.t = t;
  out.T_odom_body = last_posterior_.T_odom_body;
  out.T_odom_body.p += forgotten_s * last_posterior_.v;
  out.v = kept * last_posterior_.v;
  decorrelate(out, kTheta, kGyroBias - kTheta);
  const double turn_rad = turn_sigma_rad(gap_s);
  const Vec3 up_body = -out.T_odom_body.R.transpose() * out.g_odom_mps2.normalized();
  out.P.block<3, 3>(kTheta, kTheta) = kTilt_rad * kTilt_rad * Mat3::Identity() +
                                      turn_rad * turn_rad * up_body * up_body.transpose();
  const Mat3 v2 = sigma_mps * sigma_mps * Mat3::Identity();
  out.P.block<3, 3>(kVel, kVel) = (1.0 - kept * kept) * v2;
  out.P.block<3, 3>(kPos, kVel) = out.P.block<3, 3>(kVel, kPos) = forgotten_s * (1.0 - kept) * v2;
  out.P.block<3, 3>(kPos, kPos) =
      (2.0 * kTau_s * gap_s - kTau_s * kTau_s * (3.0 - 4.0 * kept + kept * kept)) * v2;
  return out;
}

/// Registers the scan at all places within reach that look like it. The speed is not known yet: the
/// scan is undistorted with the mean speed since the last one.
std::vector<RobustOdometry::Placed> RobustOdometry::place_again(const LidarScan& scan,
                                                                const FilterState& wide) {
  constexpr double kApart_m = 1.0;
  constexpr std::size_t kPlaces = 12;
  constexpr int kRounds = 4;  // the first moves far with few matches
  constexpr double kDegree = 180.0 / std::numbers::pi;
  const std::optional<Vec3> rate = gyro_rate(scan.t_start, scan.t_end);
  const double gap_s = seconds_between(last_posterior_.t, scan.t_end);
  const auto undistort = [&](const Vec3& v_odom_mps) {
    const SE3 T = state_.T_odom_body;
    state_ = wide;
    state_.T_odom_body = T;
    state_.v = v_odom_mps;
    poses_at_constant_speed(scan, rate);
    scan_motion(scan).apply(scan, sampler_.update_indices(), points_);
    matcher_.set_points(points_, calibration_.T_body_lidar.p);
  };
  state_ = wide;
  undistort(wide.v);
  CoarseSearchSettings search = settings_.search;
  search.range_max_m = std::min(kReachMax_m, kReachSigmas * std::sqrt(wide.P(kPos, kPos)));
  search.range_max_deg = std::min(180.0, kDegree * kReachSigmas * turn_sigma_rad(gap_s));
  const PoseGuess guess{wide.T_odom_body, search.range_max_m, search.range_max_deg / kDegree};
  const Vec3 up = -wide.g_odom_mps2.normalized();
  std::vector<SE3> starts = search_places(recent_, points_, guess, up, search, kApart_m, kPlaces);
  starts.push_back(wide.T_odom_body);
  starts.push_back(last_posterior_.T_odom_body);
  std::vector<Placed> placed;
  for (const SE3& start : starts) {
    SE3 from = start;
    UpdateResult done;
    for (int k = 0; k < kRounds; ++k) {
      state_.T_odom_body = from;
      undistort((from.p - last_posterior_.T_odom_body.p) / gap_s);
      state_ = wide;
      done = update_with_scan(state_, matcher_, map_, from, settings_, axes_, degenerate_, true);
      from = state_.T_odom_body;
    }
    placed.push_back({state_, done});
  }
  state_ = wide;
  return placed;
}

/// Takes the place where the scan fits best, unless another one fits nearly as well.
/// @return empty if it is found nowhere, or not at one place only
std::optional<UpdateResult> RobustOdometry::find_again(const LidarScan& scan,
                                                       const FilterState& wide) {
  constexpr double kGood = 0.8;     // of the usual fit
  constexpr double kAsGood = 0.85;  // of the best fit: ambiguous
  const std::vector<Placed> placed = place_again(scan, wide);
  const auto best =
      std::max_element(placed.begin(), placed.end(),
                       [](const Placed& a, const Placed& b) { return a.done.fit < b.done.fit; });
  const bool fits =
      best->done.matches >= settings_.update.matches_min && best->done.fit >= kGood * usual_fit_;
  const bool alike = std::any_of(placed.begin(), placed.end(), [&](const Placed& other) {
    return other.done.fit > kAsGood * best->done.fit &&
           are_apart(other.state.T_odom_body, best->state.T_odom_body);
  });
  // Along a degenerate direction nothing is found.
  if (!fits || alike || !best->done.known.isIdentity(1e-6)) return std::nullopt;
  state_ = best->state;
  return best->done;
}

/// The first scan after an interruption: looked for in the map. Where it is not found, inertial
/// data are interpolated over a short interruption; after a long one a new map starts at the last
/// pose, with a covariance for wherever the vehicle can have driven.
UpdateResult RobustOdometry::resume(const LidarScan& scan, FindingList& findings) {
  constexpr double kInterpolated_s = 4.0;
  const FilterState before = state_;
  const FilterState wide = anywhere_reached(scan.t_end);
  const double gap_s = seconds_between(last_posterior_.t, scan.t_end);
  motion_noise_.interrupt();
  map_tilt_.interrupt();
  standstill_.reset();
  Finding f;
  f.id = "odometry.interrupted";
  f.severity = Severity::kWarning;
  f.t = last_posterior_.t;
  f.t_end = scan.t_end;
  f.text = fmt::format("neither scans nor inertial data for {:.1f} s", gap_s);
  f.effect = "the path in between is not known";
  if (const auto found = find_again(scan, wide)) {
    T_predicted_ = wide.T_odom_body;
    P_predicted_m2_ = wide.P.block<3, 3>(kPos, kPos);
    T_last_predicted_ = last_posterior_.T_odom_body.inverse() * wide.T_odom_body;
    f.text += fmt::format(": found again in the map, {:.1f} m from the last pose",
                          (state_.T_odom_body.p - last_posterior_.T_odom_body.p).norm());
    findings.push_back(f);
    poses_at_constant_speed(scan, gyro_rate(scan.t_start, scan.t_end));
    return *found;
  }
  poses_.clear();
  if (gap_s <= kInterpolated_s) {
    // The covariance does not contain this: the next scans agree with a wrong place, too.
    f.effect = fmt::format(
        "it was not found again at one place alone and inertial data were interpolated: all poses "
        "after it may be off by {:.1f} m, or by the distance of places that look alike",
        std::sqrt(wide.P(kPos, kPos)));
    findings.push_back(f);
    state_ = before;
    return predict_and_update(scan, integrate_from(last_posterior_, imu_, scan.t_end));
  }
  f.severity = Severity::kError;
  f.effect = "a new map starts; its pose relative to the one before is not measured";
  findings.push_back(f);
  last_good_ = wide.T_odom_body;
  state_ = wide;
  start_anew();
  state_.P.topLeftCorner<6, 6>() = wide.P.topLeftCorner<6, 6>();
  return predict_and_update(scan, {});
}

}  // namespace rali::odometry::internal
