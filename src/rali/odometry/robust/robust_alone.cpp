#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/odometry/robust/internal/robust_filter.hpp"
#include "rali/odometry/robust/wide_search.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

/// Without inertial data, scans farther apart than this are not consecutive: the velocity may have
/// changed arbitrarily.
constexpr double kFarApart_s = 0.25;
constexpr int kYoungMap = 3;
/// Limits of motion between scans, for a sensor in the hand or on a vehicle indoors.
constexpr double kSpeed_mps = 10.0;
constexpr double kTurn_radps = 4.0;
/// Fraction of points seen by both of two scans. At the right pose, edges and passers-by cause
/// less.
constexpr double kConflictMax = 0.03;
/// Scans of a hand-held sensor and of a car have at most 0.002: above this a second search is made.
constexpr double kConflictUsual = 0.004;

/// The last reliable state, propagated to `t`, with a covariance for any motion within the limits.
FilterState anywhere_near(const FilterState& last, Time t) {
  constexpr double kSigmas = 2.0;
  const double span_s = (t - last.t).s();
  FilterState out = last;
  out.t = t;
  out.v.setZero();
  out.gyro_bias_radps.setZero();
  const double v = kSpeed_mps / kSigmas;
  const double w = kTurn_radps / kSigmas;
  const double turn = std::min(w * span_s, std::numbers::pi / 2.0);
  const double w_used = span_s > 0.0 ? turn / span_s : w;
  decorrelate(out, kTheta, kAccelBias);
  const auto set = [&out, span_s](int pose, int rate, const Mat3& R, double sigma) {
    const double var = sigma * sigma;
    out.P.block<3, 3>(pose, pose) += span_s * span_s * var * Mat3::Identity();
    out.P.block<3, 3>(rate, rate) = var * Mat3::Identity();
    out.P.block<3, 3>(pose, rate) = span_s * var * R;
    out.P.block<3, 3>(rate, pose) = span_s * var * R.transpose();
  };
  set(kPos, kVel, out.T_odom_body.R, v);
  set(kTheta, kGyroBias, Mat3::Identity(), w_used);
  return out;
}

}  // namespace

double RobustOdometry::conflict_at(const ScanView& view) const {
  if (!last_view_) return 0.0;
  const SE3 T_odom_lidar = state_.T_odom_body * calibration_.T_body_lidar;
  const SE3 T_odom_last = last_settled_.T_odom_body * calibration_.T_body_lidar;
  return last_view_->compare(view, T_odom_last.inverse() * T_odom_lidar).conflict();
}

/// Without inertial data the prediction may be arbitrary, and the nearest minimum of the
/// registration a wrong one. A pose is rejected if the rays of two consecutive scans pass through
/// surfaces of the other. The scan is then searched wherever the vehicle can have moved.
/// @return false if it fits nowhere
bool RobustOdometry::settle_alone(const LidarScan& scan, const FilterState& predicted,
                                  UpdateResult& done) {
  constexpr double kPoor = 0.6;  // of the usual fit
  constexpr double kGain = 0.2;
  BodyPoints body;
  scan_motion(scan).apply(scan, sampler_.insert_indices(), body);
  ScanView view(body, calibration_.T_body_lidar.p);
  const int matches_min = settings_.update.matches_min;
  if (last_view_) {
    const bool far_apart = (scan.t_end - last_posterior_.t).s() > kFarApart_s;
    const bool young = scans_in_map_ <= kYoungMap && far_apart;
    double conflict = conflict_at(view);
    const bool unlikely = young || done.matches < matches_min || done.fit < kPoor * usual_fit_ ||
                          conflict > kConflictUsual;
    if (unlikely && settings_.search.wide) {
      search_widely(predicted, view, done);
      conflict = conflict_at(view);
    }
    const bool odd = conflict > kConflictUsual && done.fit < kPoor * usual_fit_;
    if (conflict > kConflictMax || odd) return false;
  }
  if (done.matches >= matches_min) {
    usual_fit_ += (usual_fit_ > 0.0 ? kGain : 1.0) * (done.fit - usual_fit_);
  }
  last_view_ = std::make_unique<ScanView>(std::move(view));
  last_settled_ = state_;
  return true;
}

/// The first scan of a map is the reference for the next.
void RobustOdometry::start_view(const LidarScan& scan) {
  if (has_imu_) return;
  BodyPoints body;
  scan_motion(scan).apply(scan, sampler_.insert_indices(), body);
  last_view_ = std::make_unique<ScanView>(body, calibration_.T_body_lidar.p);
  last_settled_ = state_;
}

/// Searches the pose wherever the vehicle can have moved since the last scan that fitted, nearby
/// first: far away some position fits to some degree at each heading.
void RobustOdometry::search_widely(const FilterState& predicted, const ScanView& view,
                                   UpdateResult& done) {
  constexpr double kReaches[] = {0.2, 1.0};
  constexpr int kPoints = 250;
  constexpr std::size_t kHeadings = 12;
  constexpr double kDegree = 180.0 / std::numbers::pi;
  const Vec3 up = -state_.g_odom_mps2.normalized();
  const double span_s = std::max(1e-3, (predicted.t - last_settled_.t).s());
  const FilterState wide = anywhere_near(last_settled_, predicted.t);
  CoarseSearchSettings search = settings_.search;
  search.range_max_deg = std::min(180.0, kDegree * kTurn_radps * span_s);
  search.points = kPoints;
  PoseGuess guess;
  guess.T_odom_body = last_settled_.T_odom_body;
  guess.sigma_rad = 0.5 * search.range_max_deg / kDegree;
  for (const double reach : kReaches) {
    search.range_max_m = reach * kSpeed_mps * span_s;
    guess.sigma_m = 0.5 * search.range_max_m;
    for (const SE3& start : search_headings(recent_, points_, guess, up, search, kHeadings)) {
      try_start(wide, start, view, done);
    }
  }
}

/// Registers from `start` and keeps the result if the scan fits better there or, unlike at the
/// current pose, contradicts nothing.
void RobustOdometry::try_start(const FilterState& wide, const SE3& start, const ScanView& view,
                               UpdateResult& done) {
  constexpr double kBetter = 1.2;
  constexpr int kRounds = 2;  // the first moves far with few matches
  const FilterState best = state_;
  const bool was_possible = conflict_at(view) < kConflictMax;
  SE3 from = start;
  UpdateResult elsewhere;
  for (int round = 0; round < kRounds; ++round) {
    state_ = wide;
    elsewhere =
        update_with_scan(state_, matcher_, map_, from, settings_, axes_, degenerate_, false);
    from = state_.T_odom_body;
  }
  const bool possible = conflict_at(view) < kConflictMax;
  const bool better = possible == was_possible ? elsewhere.fit > kBetter * done.fit : possible;
  if (elsewhere.matches < settings_.update.matches_min || !better) {
    state_ = best;
    return;
  }
  done = elsewhere;
}

/// A scan that fits nowhere: the pose stays at the last reliable one, with a covariance for any
/// motion since then. After a while a new map starts there.
void RobustOdometry::stray(const FilterState& predicted, FindingList& findings) {
  constexpr double kLost_s = 2.0;
  constexpr double kLostScans = 4.0;
  const Time t_before = last_posterior_.t;
  state_ = anywhere_near(last_settled_, predicted.t);
  track_state_ = TrackState::kDiverged;
  const double lost_s = (state_.t - last_settled_.t).s();
  if (lost_s >= std::max(kLost_s, kLostScans * (state_.t - t_before).s())) {
    const StateCov P = state_.P;
    restart("", findings);
    state_.P.topLeftCorner<6, 6>() = P.topLeftCorner<6, 6>();
    last_view_.reset();
    usual_fit_ = 0.0;
    return;
  }
  Finding f;
  f.id = "odometry.diverged";
  f.severity = Severity::kError;
  f.t = t_before;
  f.t_end = state_.t;
  f.text = "a scan contradicts the one before wherever it is placed";
  f.effect = "this stretch is cut from the map";
  f.remedy =
      "Record more scans per second, or inertial data: they measure the motion between two scans.";
  findings.push_back(f);
}

}  // namespace rali::odometry::internal
