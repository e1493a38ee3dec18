#include "rali/vehicle/paper_range_stage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rali/ranging/range_model.hpp"
#include "rali/ranging/signal_quality.hpp"
#include "rali/vehicle/inertial_factor.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;
using odometry::KeyframeInertia;
using odometry::KeyframeMove;
using odometry::ScanResult;
using ranging::Correction;
using ranging::CorrectionOutcome;
using ranging::PaperFactor;
using ranging::PaperThenFactor;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

namespace {

/// No fleet has more pairs, and a hostile recording must not create pairs without end.
constexpr std::size_t kPairsMax = 64;

/// Odom's z axis is up in preset `paper`, by construction.
const Vec3 kUpOdom = Vec3::UnitZ();

RangeReason reason_of(CorrectionOutcome outcome) {
  switch (outcome) {
    case CorrectionOutcome::kCorrected:
      return RangeReason::kUsed;
    case CorrectionOutcome::kNotNeeded:
      return RangeReason::kNotNeeded;
    case CorrectionOutcome::kAmbiguous:
    case CorrectionOutcome::kTooSensitive:
    case CorrectionOutcome::kDirectionUnknown:
      return RangeReason::kBadGeometry;
    case CorrectionOutcome::kInconsistent:
    case CorrectionOutcome::kTooFar:
      break;
  }
  return RangeReason::kBlockedByGate;
}

RangeUse use_of(const RangeSample& sample, RangeReason reason) {
  RangeUse use;
  use.sample = sample;
  use.reason = reason;
  return use;
}

}  // namespace

PaperRangeStage::PaperRangeStage(VehicleId self, const VehicleSettings& settings)
    : self_(self),
      settings_(settings),
      paper_(settings.ranging.paper.resolved(settings.odometry.paper.literal)),
      degree_(settings.paper_degree.resolved(settings.odometry.paper.literal)),
      literal_(settings.odometry.paper.literal),
      peers_(watch_peers(settings)),
      window_(paper_, literal_ ? PaperSteps::kIsotropic : PaperSteps::kDegenerate) {}

void PaperRangeStage::add(const RangeSample& sample, OutputList& out) {
  if (!settings_.ranging.use || !understand(sample)) {
    const bool wanted = settings_.ranging.use;
    out.emplace_back(use_of(sample, wanted ? RangeReason::kUnknownId : RangeReason::kNoPose));
    return;
  }
  const auto after = std::upper_bound(waiting_.begin(), waiting_.end(), sample.t,
                                      [](Time t, const RangeSample& s) { return t < s.t; });
  waiting_.insert(after, sample);
}

void PaperRangeStage::on(const PeerStatus& status) {
  const auto found = peers_.find(status.vehicle);
  if (found == peers_.end()) return;
  found->second.on(status, settings_.ranging.place_stay_m, settings_.ranging.status_valid_s);
  if (found->second.at_rest) return;
  // A peer that drives off is no landmark any more, and its ranges no longer lie on a line.
  for (auto& [key, pair] : pairs_) {
    if (std::get<1>(key) == status.vehicle) forget_landmark(pair);
  }
}

void PaperRangeStage::forget_landmark(Pair& pair) {
  pair.smoother.reset();
  pair.finder.reset();
  pair.newest.reset();
  pair.p_odom_peer_m.reset();
  if (pair.calibration) pair.calibration->end_stay();
  pair.sought.clear();
}

/// Own antenna, peer and its antenna; nothing if an end is unknown.
std::optional<PaperRangeStage::PairKey> PaperRangeStage::understand(
    const RangeSample& sample) const {
  const bool forth = sample.from == self_;
  if (!forth && sample.to != self_) return std::nullopt;
  const VehicleId peer = forth ? sample.to : sample.from;
  const std::uint8_t own = forth ? sample.from_antenna : sample.to_antenna;
  const std::uint8_t other = forth ? sample.to_antenna : sample.from_antenna;
  const auto found = peers_.find(peer);
  if (found == peers_.end() || own >= settings_.antennas_body_m.size() ||
      other >= found->second.settings.antennas_body_m.size()) {
    return std::nullopt;
  }
  return PairKey{own, peer, other};
}

PaperRangeStage::Pair& PaperRangeStage::pair_of(const PairKey& key) {
  const auto found = pairs_.find(key);
  if (found != pairs_.end()) return found->second;
  const double given_m = peers_.at(std::get<1>(key)).settings.bias_m.value_or(0.0);
  return pairs_.emplace(key, Pair(settings_.ranging, paper_, given_m)).first->second;
}

Vec3 PaperRangeStage::own_end(const PairKey& key) const {
  if (paper_.range_point == ranging::PaperRangePoint::kBody) return Vec3::Zero();
  return settings_.antennas_body_m[std::get<0>(key)];
}

Vec3 PaperRangeStage::peers_end(const PairKey& key) const {
  if (paper_.range_point == ranging::PaperRangePoint::kBody) return Vec3::Zero();
  return peers_.at(std::get<1>(key)).settings.antennas_body_m[std::get<2>(key)];
}

void PaperRangeStage::before_scan(Time t_end, OutputList& out) {
  while (!waiting_.empty() && waiting_.front().t <= t_end) {
    const RangeSample sample = waiting_.front();
    waiting_.pop_front();
    take(sample, out);
  }
}

void PaperRangeStage::take(const RangeSample& sample, OutputList& out) {
  const PairKey key = *understand(sample);
  if (pairs_.size() >= kPairsMax && !pairs_.contains(key)) {
    out.emplace_back(use_of(sample, RangeReason::kUnknownId));
    return;
  }
  Pair& pair = pair_of(key);
  const double sigma_m =
      ranging::sigma_of(sample.range_m, settings_.ranging.limits, sample.sigma_m);
  if (const auto wrong = pair.sanity.check(sample.t, sample.range_m, sigma_m, std::nan(""))) {
    out.emplace_back(use_of(sample, *wrong));
    return;
  }
  if (!peers_.at(std::get<1>(key)).stands_at(sample.t, settings_.ranging.status_valid_s)) {
    out.emplace_back(use_of(sample, RangeReason::kNoPose));
    return;
  }
  pair.newest = pair.smoother.add(sample.t, sample.range_m - pair.bias_m);
  if (!ranging::signal_quality(sample, settings_.ranging.signal).clear()) {
    pair.t_unclear = sample.t;
  }
  fix_landmark(key, pair);
  if (!pair.p_odom_peer_m) {
    pair.sought.push_back(sample);
    out.emplace_back(use_of(sample, RangeReason::kNoPose));
    return;
  }
  Pending pending;
  pending.use = use_of(sample, RangeReason::kNotNeeded);
  pair.pending.push_back(pending);
}

std::optional<Vec3> PaperRangeStage::degenerate_direction(std::span<const Vec3> normals_body,
                                                          const Vec3& up_body) const {
  const degeneracy::PaperDegree degree = degeneracy::paper_degree(normals_body, up_body, degree_);
  if (!degree.degenerate || !degree.direction_known) return std::nullopt;
  return degree.direction_body;
}

degeneracy::PaperDegree PaperRangeStage::degree_of(const ScanResult& scan) const {
  const Vec3 up_body = scan.T_odom_body.R.transpose() * kUpOdom;
  return degeneracy::paper_degree(scan.feature_normals_body, up_body, degree_);
}

/// At the first scan after a degenerate stretch the position still depends on the prediction along
/// it: this scan counts as the stretch's last.
degeneracy::PaperDegree PaperRangeStage::degree_until(const ScanResult& scan) const {
  degeneracy::PaperDegree degree = degree_of(scan);
  const bool next = degenerate_odom_ && seconds_between(t_last_, scan.t) <= paper_.smoother_s;
  if (literal_ || degree.degenerate || !next) return degree;
  degree.degenerate = true;
  degree.direction_known = true;
  degree.direction_body = scan.T_odom_body.R.transpose() * *degenerate_odom_;
  return degree;
}

std::optional<KeyframeMove> PaperRangeStage::at_keyframe(const ScanResult& scan,
                                                         const KeyframeInertia& inertia) {
  const degeneracy::PaperDegree degree = degree_until(scan);
  const bool lost = scan.state == odometry::TrackState::kDiverged;
  if (lost) window_.clear();  // a new map: no factor connects it to the old one
  const std::uint32_t seq = next_seq_++;
  const Vec3 e3_odom = scan.T_odom_body.R * degree.direction_body;
  const bool degenerate = degree.degenerate && degree.direction_known;
  PaperWindow::Node node = node_of(seq, scan, inertia);
  if (degenerate) node.e3_odom = e3_odom;
  window_.add(std::move(node), degree.degenerate);
  reported_[seq] = scan.T_odom_body;
  passage_odom_ = degenerate ? std::optional(e3_odom) : std::nullopt;
  // At standstill the pose does not slip: a gap is an error of the peer's position or of the pair.
  if (lost || (scan.at_rest && !literal_)) return std::nullopt;
  const std::optional<Candidate> candidate = best_candidate(scan, e3_odom);
  if (!candidate) return std::nullopt;
  const Correction done = correct(*candidate, scan, degree, inertia.T_odom_body_predicted);
  count(done);
  const bool moved = apply(done, *candidate, wants_factor(done, degenerate, candidate->along));
  judge(done.outcome, moved, *candidate->pair);
  if (!moved) return std::nullopt;
  const SE3& T_new = window_.nodes().back().T_odom_body;
  reported_[seq] = T_new;
  T_uncorrected_ = scan.T_odom_body;
  effect_.shift_m = (T_new.p - scan.T_odom_body.p).norm();
  effect_.from = candidate->peer;
  KeyframeMove move = move_of_window();
  if (degenerate) move.known = known_along(*candidate, e3_odom, T_new.p - scan.T_odom_body.p);
  return move;
}

PaperWindow::Node PaperRangeStage::node_of(std::uint32_t seq, const ScanResult& scan,
                                           const KeyframeInertia& inertia) const {
  PaperWindow::Node node;
  node.seq = seq;
  node.t = scan.t;
  node.T_odom_body = scan.T_odom_body;
  node.covariance = scan.covariance;
  node.motion = inertia.motion;
  if (inertia.since_last != nullptr) {
    node.inertial = inertial_factor(*inertia.since_last, settings_.odometry.imu_noise,
                                    settings_.calibration.T_body_imu);
  }
  return node;
}

/// The pair with its line of sight nearest to the degenerate direction: its range gives most
/// information, with the least error.
std::optional<PaperRangeStage::Candidate> PaperRangeStage::best_candidate(const ScanResult& scan,
                                                                          const Vec3& e3_odom) {
  std::optional<Candidate> best;
  double best_along = -1.0;
  for (auto& [key, pair] : pairs_) {
    const std::optional<Candidate> found = candidate_of(key, pair, scan);
    if (!found) continue;
    const Vec3 sight = scan.T_odom_body * found->p_body_m - *pair.p_odom_peer_m;
    const double along = std::abs(sight.normalized().dot(e3_odom));
    if (!(along > best_along)) continue;
    best = found;
    best->p_odom_m = scan.T_odom_body * found->p_body_m;
    best->along = along;
    best_along = along;
  }
  return best;
}

std::optional<PaperRangeStage::Candidate> PaperRangeStage::candidate_of(
    const PairKey& key, Pair& pair, const ScanResult& scan) const {
  if (!pair.newest || !pair.p_odom_peer_m) return std::nullopt;
  const ranging::SmoothedRange& smoothed = *pair.newest;
  const double age_s = seconds_between(smoothed.t, scan.t);
  const bool stands =
      peers_.at(std::get<1>(key)).stands_at(scan.t, settings_.ranging.status_valid_s);
  const int minimum =
      paper_.smoother == ranging::PaperSmoother::kNone ? 1 : paper_.smoother_samples_min;
  // As in the smoother itself: after a gap of half its length the link is lost.
  if (!stands || age_s > 0.5 * paper_.smoother_s || smoothed.samples < minimum) return std::nullopt;
  Candidate out;
  out.pair = &pair;
  out.peer = std::get<1>(key);
  out.p_body_m = own_end(key);
  if (paper_.range_time == ranging::PaperRangeTime::kMeasured) {
    out.p_body_m -= scan.T_odom_body.R.transpose() * scan.v_odom_mps * age_s;
  }
  return out;
}

Correction PaperRangeStage::correct(const Candidate& candidate, const ScanResult& scan,
                                    const degeneracy::PaperDegree& degree,
                                    const SE3& T_odom_body_predicted) const {
  ranging::CorrectionInput in;
  in.p_m = scan.T_odom_body * candidate.p_body_m;
  in.anchor_m = *candidate.pair->p_odom_peer_m;
  in.range_m = candidate.pair->smoothed_m();
  in.e3 = scan.T_odom_body.R * degree.direction_body;
  in.degenerate = degree.degenerate;
  const Vec3 step = T_odom_body_predicted * candidate.p_body_m - in.p_m;
  const bool flat = paper_.range_2d != ranging::PaperRange2d::k3d;
  const auto e = ranging::horizontal_direction(in.e3, flat ? paper_.min_horizontal : 0.0);
  if (e) in.imu_s_m = step.dot(flat ? *e : in.e3.normalized());
  return ranging::correct_on_circle(in, paper_);
}

/// A range across the degenerate direction does not constrain it, but disturbs what the LiDAR
/// constrains.
bool PaperRangeStage::wants_factor(const Correction& done, bool degenerate, double along) const {
  const bool corrected = done.outcome == CorrectionOutcome::kCorrected;
  const bool fits = done.outcome == CorrectionOutcome::kNotNeeded;
  switch (paper_.factor) {
    case PaperFactor::kDegenerate:
      return corrected || (fits && degenerate && along * paper_.max_sensitivity >= 1.0);
    case PaperFactor::kCorrected:
      return corrected;
    case PaperFactor::kAlways:
      return true;
    case PaperFactor::kNone:
      break;
  }
  return false;
}

/// @return whether the range moved keyframes
bool PaperRangeStage::apply(const Correction& done, const Candidate& candidate, bool factor) {
  const bool corrected = done.outcome == CorrectionOutcome::kCorrected;
  const bool state = corrected && paper_.correct_then_factor == PaperThenFactor::kState;
  if (!factor && !state) return false;
  if (corrected) window_.shift_newest(done.shift_m);
  if (!factor) return true;
  PaperRangeFactor range;
  range.t = candidate.pair->newest->t;
  range.p_body_m = candidate.p_body_m;
  range.p_odom_peer_m = *candidate.pair->p_odom_peer_m;
  range.range_m = candidate.pair->smoothed_m();
  window_.set_range(range);
  window_.solve();
  return true;
}

void PaperRangeStage::count(const Correction& done) {
  ++outcomes_[static_cast<std::size_t>(done.outcome)];
  if (done.closest && done.outcome == CorrectionOutcome::kCorrected) ++closest_;
  longest_m_ = std::max(longest_m_, std::abs(done.s_m));
}

/// If a smoothed range is used, all ranges in its fit were used. If it is refused, the others of
/// its fit may still be used at the next keyframe.
void PaperRangeStage::judge(CorrectionOutcome outcome, bool used, Pair& pair) const {
  if (!used && reason_of(outcome) == RangeReason::kNotNeeded) return;
  const Time newest = pair.newest->t;
  for (Pending& pending : pair.pending) {
    const bool fitted = seconds_between(pending.use.sample.t, newest) <= paper_.smoother_s;
    if (pending.decided || !fitted || (!used && pending.use.sample.t != newest)) continue;
    pending.use.reason = used ? RangeReason::kUsed : reason_of(outcome);
    pending.use.sigma_m = std::sqrt(pair.newest->variance_m2);
    pending.decided = true;
  }
}

KeyframeMove PaperRangeStage::move_of_window() const {
  KeyframeMove move;
  for (const PaperWindow::Node& node : window_.nodes()) move.earlier.push_back(node.T_odom_body);
  move.T_odom_body = move.earlier.back();
  move.earlier.pop_back();
  return move;
}

}  // namespace rali::vehicle
