#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "rali/odometry/robust/internal/robust_filter.hpp"
#include "rali/odometry/robust/wide_search.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

/// In this time a vehicle can stop, start and turn: the samples before and after an interruption
/// do not determine the motion in between.
constexpr double kUnknown_s = 1.0;
/// Until then a vehicle is not far from where its inertial data, interpolated, put it.
constexpr double kShort_s = 4.0;
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

/// The points of the scan, undistorted with a guess of the speed.
void RobustOdometry::undistort_at(const LidarScan& scan, const SE3& T_odom_body,
                                  const Vec3& v_odom_mps) {
  const Vec3 v = std::exchange(state_.v, v_odom_mps);
  const SE3 T = std::exchange(state_.T_odom_body, T_odom_body);
  poses_at_constant_speed(scan, gyro_rate(scan.t_start, scan.t_end));
  scan_motion(scan).apply(scan, sampler_.update_indices(), points_);
  matcher_.set_points(points_, calibration_.T_body_lidar.p);
  state_.v = v;
  state_.T_odom_body = T;
}

RobustOdometry::Placed RobustOdometry::register_from(const SE3& start, const FilterState& wide) {
  Placed out{wide, {}, 0.0};
  out.done =
      update_with_scan(out.state, matcher_, map_, start, settings_, axes_, degenerate_, true);
  return out;
}

/// Registers the scan at all places within reach that look like it.
std::vector<RobustOdometry::Placed> RobustOdometry::place_again(const LidarScan& scan,
                                                                const FilterState& wide) {
  constexpr double kApart_m = 1.0;
  constexpr std::size_t kPlaces = 12;
  constexpr int kRounds = 4;  // the first moves far with few matches
  constexpr double kDegree = 180.0 / std::numbers::pi;
  const double gap_s = seconds_between(last_posterior_.t, scan.t_end);
  undistort_at(scan, wide.T_odom_body, wide.v);
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
    Placed place;
    for (int k = 0; k < kRounds; ++k) {
      undistort_at(scan, from, (from.p - last_posterior_.T_odom_body.p) / gap_s);
      place = register_from(from, wide);
      from = place.state.T_odom_body;
    }
    // Several starts may converge to one place.
    const auto same = std::find_if(placed.begin(), placed.end(), [&](const Placed& other) {
      return !are_apart(other.state.T_odom_body, from);
    });
    if (same == placed.end()) {
      placed.push_back(place);
    } else if (place.done.fit > same->done.fit) {
      *same = place;
    }
  }
  for (Placed& place : placed) place = at_best_speed(scan, wide, place);
  return placed;
}

/// A wrong speed distorts a scan by a decimetre, and puts it as far off. So each place is tried at
/// several speeds, and the speed is known to one step of them.
RobustOdometry::Placed RobustOdometry::at_best_speed(const LidarScan& scan, const FilterState& wide,
                                                     const Placed& place) {
  constexpr int kSteps = 2;
  constexpr int kRounds = 2;
  const double step_mps = 0.5 * std::max(settings_.constraints.speed_usual_mps, fastest_seen_mps_);
  const SE3 there = place.state.T_odom_body;
  std::optional<Placed> best;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const Vec3 v = k * step_mps * (there.R * forward_body_);
    undistort_at(scan, there, v);
    Placed tried = register_from(there, wide);
    for (int round = 1; round < kRounds; ++round) {
      tried = register_from(tried.state.T_odom_body, wide);
    }
    tried.agreement = matcher_.overlap(map_, tried.state.T_odom_body).agreement();
    if (best && tried.agreement <= best->agreement) continue;
    tried.state.v = v;
    decorrelate(tried.state, kVel, 3);
    tried.state.P.diagonal().segment<3>(kVel).setConstant(step_mps * step_mps);
    best = tried;
  }
  return *best;
}

/// Of the places where as few points contradict the map as at the best one, takes the one nearest
/// to where the vehicle was going. The fraction of points on planes does not tell them apart: in a
/// tunnel it is 0.65 between two ribs, and 0.64 at the right place, ahead of what was seen before;
/// of the points within the extent of a plane, 0.12 contradict the map there, and 0.04 here.
/// @return empty if it is found nowhere
std::optional<RobustOdometry::FoundAgain> RobustOdometry::find_again(const LidarScan& scan,
                                                                     const FilterState& wide) {
  constexpr double kGood = 0.8;     // of the usual fit
  constexpr double kEnough = 0.5;   // of it, where hardly any point contradicts the map
  constexpr double kAgrees = 0.92;  // right places 0.95 to 0.98, wrong ones up to 0.92
  constexpr double kAsGood = 0.85;  // of the best fit: elsewhere the map has less to contradict
  constexpr double kAlike = 2.0;    // times the contradictions at the best place
  constexpr double kChance = 0.01;
  const Mat6 I = wide.P.topLeftCorner<6, 6>().inverse();
  const std::vector<Placed> placed = place_again(scan, wide);
  const bool is_short = seconds_between(last_posterior_.t, scan.t_end) <= kShort_s;
  double fit_min = 0.0, best = 0.0;
  for (const Placed& p : placed) fit_min = std::max(fit_min, kAsGood * p.done.fit);
  const auto fits = [&](const Placed& p) {
    const double usual = is_short && p.agreement > kAgrees ? kEnough : kGood;
    return p.done.fit >= std::max(usual * usual_fit_, fit_min);
  };
  for (const Placed& p : placed) {
    if (fits(p)) best = std::max(best, p.agreement);
  }
  const double agreement_min = 1.0 - kAlike * (1.0 - best) - kChance;
  double sum = 0.0, likeliest = 0.0;
  Vec3 mean_m = Vec3::Zero();
  Mat3 squares_m2 = Mat3::Zero();
  const Placed* taken = nullptr;
  FoundAgain out;
  for (const Placed& p : placed) {
    if (!fits(p) || p.agreement < agreement_min) continue;
    // Along a degenerate direction nothing is found.
    if (p.done.matches < settings_.update.matches_min || !p.done.known.isIdentity(1e-6)) return {};
    const geometry::Vec6 moved = geometry::boxminus(p.state.T_odom_body, wide.T_odom_body);
    const double weight = std::exp(-0.5 * moved.dot(I * moved));
    if (taken == nullptr || weight > likeliest) {
      taken = &p;
      likeliest = weight;
    }
    ++out.places;
    sum += weight;
    const Vec3 d = moved.tail<3>();
    mean_m += weight * d;
    squares_m2 += weight * d * d.transpose();
  }
  if (taken == nullptr) return {};
  const Vec3 d = geometry::boxminus(taken->state.T_odom_body, wide.T_odom_body).tail<3>();
  out.done = taken->done;
  if (sum > 0.0) {
    out.spread_m2 =
        (squares_m2 - mean_m * d.transpose() - d * mean_m.transpose()) / sum + d * d.transpose();
  }
  state_ = taken->state;
  return out;
}

/// A scan undistorted with a wrong speed is not for the map: the next scans would agree with what
/// it has added, and hold the wrong speed.
bool RobustOdometry::speed_is_known_again(Time t) const {
  constexpr double kKnown_mps = 0.1;
  constexpr double kPatience_s = 1.0;  // along a tunnel it stays unknown
  if (seconds_between(*resumed_, t) > kPatience_s) return true;
  const Mat3 P_v = state_.P.block<3, 3>(kVel, kVel);
  return (P_v.diagonal().array() < kKnown_mps * kKnown_mps).all();
}

void RobustOdometry::widen_position(const Mat3& covariance_m2) {
  Mat6 P = Mat6::Zero();
  P.bottomRightCorner<3, 3>() = covariance_m2;
  drift_.add_everywhere(state_.T_odom_body, P);
}

/// The first scan after an interruption: looked for in the map. Where it is not found, inertial
/// data are interpolated over a short interruption; after a long one a new map starts at the last
/// pose, with a covariance for wherever the vehicle can have driven.
UpdateResult RobustOdometry::resume(const LidarScan& scan, FindingList& findings) {
  const FilterState wide = anywhere_reached(scan.t_end);
  const double gap_s = seconds_between(last_posterior_.t, scan.t_end);
  motion_noise_.interrupt();
  standstill_.reset();
  Finding f;
  f.id = "odometry.interrupted";
  f.severity = Severity::kWarning;
  f.t = last_posterior_.t;
  f.t_end = scan.t_end;
  f.text = fmt::format("neither scans nor inertial data for {:.1f} s", gap_s);
  f.effect = "the path in between is not known";
  if (const auto found = find_again(scan, wide)) {
    resumed_ = scan.t_end;
    T_predicted_ = wide.T_odom_body;
    P_predicted_m2_ = wide.P.block<3, 3>(kPos, kPos);
    T_last_predicted_ = last_posterior_.T_odom_body.inverse() * wide.T_odom_body;
    const double moved_m = (state_.T_odom_body.p - last_posterior_.T_odom_body.p).norm();
    if (found->places == 1) {
      f.text += fmt::format(": found again in the map, {:.1f} m from the last pose", moved_m);
    } else {
      f.text += fmt::format(": {} places look alike, the likeliest is {:.1f} m from the last pose",
                            found->places, moved_m);
      f.effect = fmt::format("all poses after it may be off by {:.1f} m (1 sigma)",
                             std::sqrt(found->spread_m2.trace()));
      widen_position(found->spread_m2);
    }
    findings.push_back(f);
    poses_at_constant_speed(scan, gyro_rate(scan.t_start, scan.t_end));
    return found->done;
  }
  poses_.clear();
  if (gap_s <= kShort_s) {
    f.effect = fmt::format(
        "it was not found again at one place alone and inertial data were interpolated: all poses "
        "after it may be off by {:.1f} m, or by the distance of places that look alike",
        std::sqrt(wide.P(kPos, kPos)));
    findings.push_back(f);
    widen_position(wide.P.block<3, 3>(kPos, kPos));
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
