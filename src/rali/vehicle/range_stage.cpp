#include "rali/vehicle/range_stage.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "rali/ranging/path_fit.hpp"
#include "rali/ranging/range_model.hpp"
#include "rali/ranging/seen_space.hpp"
#include "rali/ranging/signal_quality.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using odometry::AugmentedStates;
using odometry::Moment;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

namespace {

fleet::RangeEntry entry_of(const RangeSample& sample, const Moment& now, double sigma_m) {
  fleet::RangeEntry entry;
  entry.t = sample.t;
  entry.from = sample.from;
  entry.to = sample.to;
  entry.from_antenna = sample.from_antenna;
  entry.to_antenna = sample.to_antenna;
  entry.range_m = sample.range_m;
  entry.sigma_m = sigma_m;
  entry.T_odom_body = now.T_odom_body;
  entry.at_rest = now.at_rest;
  return entry;
}

/// Each peer numbers its own antennas. No fleet has more pairs, and a hostile recording must not
/// create pairs without end.
constexpr std::size_t kPairsMax = 64;

/// Largest widening of the covariance: one run of wrong ranges must not discard the pose.
constexpr double kWidenMax = 16.0;

}  // namespace

RangeStage::RangeStage(VehicleId self, const VehicleSettings& settings)
    : self_(self), settings_(settings), peers_(watch_peers(settings)) {}

void RangeStage::add(const RangeSample& sample, OutputList& out) {
  PairKey key;
  if (!settings_.ranging.use || !understand(sample, key)) {
    RangeUse use;
    use.sample = sample;
    use.reason = settings_.ranging.use ? RangeReason::kUnknownId : RangeReason::kNoPose;
    out.emplace_back(use);
    return;
  }
  if (!waiting_.empty() && sample.t < waiting_.back().t) {
    const auto after = std::upper_bound(waiting_.begin(), waiting_.end(), sample.t,
                                        [](Time t, const RangeSample& s) { return t < s.t; });
    waiting_.insert(after, sample);
    return;
  }
  waiting_.push_back(sample);
}

void RangeStage::on(const PeerStatus& status) {
  const auto found = peers_.find(status.vehicle);
  if (found != peers_.end())
    found->second.on(status, settings_.ranging.place_stay_m, settings_.ranging.status_valid_s);
}

/// Own antenna, peer and its antenna; false if an end is unknown or there are too many pairs.
bool RangeStage::understand(const RangeSample& sample, PairKey& key) const {
  const bool forth = sample.from == self_;
  if (!forth && sample.to != self_) return false;
  const VehicleId peer = forth ? sample.to : sample.from;
  const std::uint8_t own = forth ? sample.from_antenna : sample.to_antenna;
  const std::uint8_t other = forth ? sample.to_antenna : sample.from_antenna;
  const auto found = peers_.find(peer);
  if (found == peers_.end() || own >= settings_.antennas_body_m.size() ||
      other >= found->second.settings.antennas_body_m.size()) {
    return false;
  }
  key = {own, peer, other};
  return pairs_.size() < kPairsMax || pairs_.contains(key);
}

RangeStage::Pair& RangeStage::pair_of(const PairKey& key) {
  const auto found = pairs_.find(key);
  if (found != pairs_.end()) return found->second;
  const ranging::RangingSettings& r = settings_.ranging;
  const std::optional<double> given = peers_.at(std::get<1>(key)).settings.bias_m;
  const double sigma_m = ranging::bias_sigma_m(r.bias, given.has_value());
  return pairs_.emplace(key, Pair(r, given.value_or(0.0), sigma_m)).first->second;
}

RangeEffect RangeStage::run(Time t_end, AugmentedFilter* filter, const Vec3& g_odom_mps2,
                            const std::optional<SE3>& first_pose, OutputList& out) {
  RangeEffect effect;
  entries_.clear();
  up_odom_ = -g_odom_mps2.normalized();
  first_pose_ = first_pose;
  if (filter != nullptr) forget_moved(*filter);
  while (!waiting_.empty() && waiting_.front().t <= t_end) {
    RangeUse use;
    use.sample = waiting_.front();
    waiting_.pop_front();
    if (filter != nullptr) this->use(use.sample, *filter, effect, use);
    out.emplace_back(use);
  }
  return effect;
}

void RangeStage::flush(OutputList& out) {
  for (const RangeSample& sample : waiting_) {
    RangeUse use;
    use.sample = sample;
    out.emplace_back(use);
  }
  waiting_.clear();
}

void RangeStage::use(const RangeSample& sample, AugmentedFilter& filter, RangeEffect& effect,
                     RangeUse& use) {
  PairKey key;
  if (!understand(sample, key)) {
    use.reason = RangeReason::kUnknownId;
    return;
  }
  Pair& pair = pair_of(key);
  const ranging::RangingSettings& r = settings_.ranging;
  double sigma_m = ranging::sigma_of(sample.range_m, r.limits, sample.sigma_m);
  const ranging::SignalQuality signal = ranging::signal_quality(sample, r.signal);
  use.p_los = signal.p_los;
  const std::optional<Moment> now = filter.advance_to(sample.t);
  posed_ = posed_ || now.has_value();
  if (now) remember_place(now->T_odom_body.p);
  const bool stands = peers_.at(std::get<1>(key)).stands_at(sample.t, r.status_valid_s);
  std::optional<Prediction> prediction;
  if (now && stands) prediction = predict_known(*now, key, pair, sample, sigma_m, filter);
  const double rate = prediction ? prediction->rate_mps : std::nan("");
  if (const auto wrong = pair.sanity.check(sample.t, sample.range_m, sigma_m, rate)) {
    use.reason = *wrong;
    return;
  }
  pair.received = {sample.t, sample.range_m};
  sigma_m *= signal.sigma_factor;
  if (now) entries_.push_back(entry_of(sample, *now, sigma_m));
  if (!prediction) {
    use.reason = now || !stands || !posed_ ? RangeReason::kNoPose : RangeReason::kLate;
    const LandmarkKey landmark_key{std::get<1>(key), std::get<2>(key)};
    const bool sought = !places_.contains(landmark_key);
    if (now && stands && sought) initialise_landmark(key, *now, sample, sigma_m, filter);
    if (now && stands && !sought) forget_unfit(landmark_key, pair, sample.t, false, filter);
    return;
  }
  bool clear = signal.clear();
  if (blocked(pair, sample.t, *prediction, filter)) {
    sigma_m *= r.sight.sigma_factor;
    use.p_los = std::isnan(use.p_los) ? r.signal.p_los_blocked
                                      : std::min(use.p_los, r.signal.p_los_blocked);
    clear = false;
  }
  sigma_m = std::hypot(sigma_m, prediction->bent_sigma_m);
  judge(pair, sample, *prediction, sigma_m, clear, filter, use);
  if (use.used()) {
    const double inflation = pair.thinning.inflation(sample.t, sigma_m, now->at_rest);
    const double R_m2 = pair.R_m2 * inflation;
    const Vec3 shift = prediction->passage ? update_in_passage({std::get<1>(key), std::get<2>(key)},
                                                               *prediction, R_m2, filter)
                                           : filter.apply(prediction->measurement, R_m2);
    effect.shift_m += shift.norm();
    effect.from = std::get<1>(key);
  }
  // What is refused as too long says nothing about the landmark.
  const bool fits = use.used() || pair.excess.in_excess();
  forget_unfit({std::get<1>(key), std::get<2>(key)}, pair, sample.t, fits, filter);
}

/// Steps, gate and link (algorithms 4.3, steps 4 to 6); `use` gets the outcome.
void RangeStage::judge(Pair& pair, const RangeSample& sample, Prediction& prediction,
                       double sigma_m, bool clear, AugmentedFilter& filter, RangeUse& use) {
  odometry::AugmentedMeasurement& m = prediction.measurement;
  m.residual = sample.range_m - prediction.predicted_m;
  const double H_P_H = prediction.passage ? prediction.variance_m2 : filter.variance(m);
  const double S = H_P_H + sigma_m * sigma_m;
  use.predicted_m = prediction.predicted_m;
  use.residual_m = m.residual;
  use.bias_m = prediction.bias_m;
  use.sigma_m = std::sqrt(S);
  if (is_excess(pair, sample, prediction, sigma_m, std::sqrt(H_P_H), filter)) {
    use.reason = RangeReason::kNlos;
    return;
  }
  // Behind an obstacle a range is longer by any length: it only says how far the other is at most.
  if (pair.blocked && m.residual > 0.0) {
    use.reason = RangeReason::kNlos;
    return;
  }
  const ranging::LinkDecision decision =
      pair.link.decide({sample.t, m.residual, S, sigma_m, clear});
  if (decision.advice == ranging::LinkAdvice::kWeAreWrong) filter.widen(decision.widen_factor);
  use.reason = decision.use ? RangeReason::kUsed : decision.reason;
  pair.R_m2 = decision.gate.R_m2;
}

/// True while the range is longer than the line of sight. If the track started with such ranges,
/// the pose has followed them: its covariance grows by their error.
bool RangeStage::is_excess(Pair& pair, const RangeSample& sample, const Prediction& prediction,
                           double sigma_m, double pose_sigma_m, AugmentedFilter& filter) const {
  if (!settings_.ranging.excess.use) return false;
  const Vec3 sight = (prediction.p_odom_antenna_m - prediction.p_odom_peer_m).normalized();
  const Vec3 turned = pair.sight_turn.add(sample.t, sight);
  odometry::AugmentedMeasurement speed;
  speed.d_velocity = sight.transpose();
  speed.d_augmented = AugmentedStates::Vector::Zero(filter.augmented().size());
  ranging::ExcessSample watched;
  watched.t = sample.t;
  watched.range_m = sample.range_m;
  watched.sigma_m = sigma_m;
  // The rate between two ranges is not quite that at both.
  constexpr double kRate_mps = 0.03;
  watched.speed_sigma_mps =
      std::hypot(kRate_mps, std::sqrt(std::max(0.0, filter.covariance({speed})(0, 0))));
  watched.residual_m = prediction.measurement.residual;
  watched.pose_sigma_m = pose_sigma_m;
  watched.turn_sigma_m = std::sqrt(turned.dot(prediction.P_between_m2 * turned));
  // By the predicted rate: a correction of the pose is no motion. Over missing ranges the rate
  // changes, but without ranges there are few corrections.
  const double distance_m = (prediction.p_odom_antenna_m - prediction.p_odom_peer_m).norm();
  if (pair.watched) {
    const double dt_s = seconds_between(pair.watched->t, sample.t);
    watched.change_m = dt_s > ranging::kSteadySpeed_s
                           ? distance_m - pair.watched->distance_m
                           : 0.5 * (pair.watched->rate_mps + prediction.rate_mps) * dt_s;
  }
  pair.watched = {sample.t, distance_m, prediction.rate_mps};
  const ranging::ExcessVerdict verdict = pair.excess.look(watched);
  if (verdict == ranging::ExcessVerdict::kRelieved) {
    // The estimate that followed the long ranges is wrong by the step: at standstill the landmark,
    // else the pose. Not both: the two would drift along the line of sight together.
    const double was = std::max(1e-3, pose_sigma_m);
    const double wrong = pair.excess.step_m();
    for (int k = 0; k < 3 && prediction.at_rest; ++k) {
      filter.walk_side(prediction.place + k, wrong * wrong * sight[k] * sight[k]);
    }
    if (!prediction.at_rest) {
      filter.widen(std::clamp(1.0 + wrong * wrong / (was * was), 1.0, kWidenMax));
    }
    return false;
  }
  return verdict != ranging::ExcessVerdict::kNone;
}

/// Checked again only after some time or distance: ray casting in the map costs more than the rest.
/// Walls must block the line wherever the other may be: a peer in a tunnel is often known only
/// along it, least of all its height after a hundred metres in a tilted odom.
bool RangeStage::blocked(Pair& pair, Time t, const Prediction& prediction,
                         const AugmentedFilter& filter) const {
  const ranging::SightSettings& s = settings_.ranging.sight;
  if (!s.use) return false;
  const Vec3& p = prediction.p_odom_antenna_m;
  const bool fresh = pair.t_sight && (t - *pair.t_sight).s() < s.valid_s &&
                     (p - pair.p_sight_m).norm() < s.valid_m;
  if (fresh) return pair.blocked;
  pair.t_sight = t;
  pair.p_sight_m = p;
  const Vec3& q = prediction.p_odom_peer_m;
  const double length_m = (q - p).norm();
  pair.blocked = false;
  if (length_m < 3.0 * s.end_m) return false;
  const Vec3 end = s.end_m / length_m * (q - p);
  const auto blocks = [&](const Vec3& shift) {
    const Vec3 from = p + end, to = q - end + shift;
    return filter.surfaces_between(from, to) >= s.surfaces || leaves_seen_space(from, to, filter);
  };
  pair.blocked = blocks(Vec3::Zero());
  if (!pair.blocked) return false;
  // However the landmark was found, ranges hardly measure its height.
  constexpr double kSpread_sigmas = 2.0;
  const Vec3 rise = level_error_m(length_m) * up_odom_;
  const Eigen::SelfAdjointEigenSolver<Mat3> spread(
      Mat3(prediction.P_between_m2 + rise * rise.transpose()));
  for (int k = 0; k < 3 && pair.blocked; ++k) {
    const double sigma_m = std::sqrt(std::max(0.0, spread.eigenvalues()[k]));
    const Vec3 shift = kSpread_sigmas * sigma_m * spread.eigenvectors().col(k);
    pair.blocked = blocks(shift) && blocks(-shift);
  }
  return pair.blocked;
}

/// Whether the line leaves the space seen from the own path.
bool RangeStage::leaves_seen_space(const Vec3& p_odom_m, const Vec3& q_odom_m,
                                   const AugmentedFilter& filter) const {
  const auto between = [&](const Vec3& a, const Vec3& b) { return filter.surfaces_between(a, b); };
  return ranging::leaves_seen_space(p_odom_m, q_odom_m, [&](const Vec3& x_m) {
    return ranging::is_outside(x_m, been_odom_m_, between);
  });
}

/// Remembers where the vehicle has been.
void RangeStage::remember_place(const Vec3& p_odom_m) {
  constexpr double kSpacing_m = 3.0;
  constexpr std::size_t kPlacesMax = 200;
  if (!been_odom_m_.empty() && (been_odom_m_.back() - p_odom_m).norm() < kSpacing_m) return;
  if (been_odom_m_.size() == kPlacesMax) been_odom_m_.erase(been_odom_m_.begin());
  been_odom_m_.push_back(p_odom_m);
}

}  // namespace rali::vehicle
