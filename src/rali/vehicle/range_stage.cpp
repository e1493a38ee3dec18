#include "rali/vehicle/range_stage.hpp"

#include <algorithm>
#include <cmath>

#include "rali/ranging/range_model.hpp"
#include "rali/ranging/signal_quality.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using odometry::Moment;
using odometry::SideFilter;
using odometry::SideStates;
using ranging::RangeReason;
using ranging::RangeUse;
using sensor::RangeSample;

namespace {

/// Peers begin their numbers anew: more antennas than that nobody has, and a hostile recording
/// must not make pairs without end.
constexpr std::size_t kPairsMax = 64;

/// One wrong stretch of ranges must not throw the pose away.
constexpr double kWidenMost = 16.0;

/// Frame of priors: at the first pose, level, heading along x.
SE3 level_start(const SE3& T_odom_first, const Vec3& up_odom) {
  const Vec3 forward = T_odom_first.R.col(0);
  const Vec3 x = (forward - forward.dot(up_odom) * up_odom).normalized();
  SE3 T;
  T.R.col(0) = x;
  T.R.col(1) = up_odom.cross(x);
  T.R.col(2) = up_odom;
  T.p = T_odom_first.p;
  return T;
}

}  // namespace

RangeStage::RangeStage(VehicleId self, const VehicleSettings& settings)
    : self_(self), settings_(settings) {
  for (const PeerSettings& peer : settings.peers) {
    Peer p;
    p.settings = peer;
    peers_.emplace(peer.id, std::move(p));
  }
}

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
  if (found == peers_.end()) return;
  Peer& peer = found->second;
  if (peer.heard && status.t < peer.t_status) return;
  peer.heard = true;
  peer.t_status = status.t;
  if (peer.at_rest && !status.at_rest) peer.moved = true;
  peer.at_rest = status.at_rest;
}

/// Own antenna, peer and its antenna; false if an end is nobody's.
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
  // A bias somebody calibrated still wanders by some of what it was.
  constexpr double kCalibratedShare = 0.2;
  const double sigma_m = given ? kCalibratedShare * r.bias.sigma_m : r.bias.sigma_m;
  Pair pair(r, given.value_or(0.0), sigma_m);
  pair.number = static_cast<int>(pairs_.size());
  pair_records_.push_back({pair.number, pair.bias_m, pair.bias_sigma_m});
  return pairs_.emplace(key, std::move(pair)).first->second;
}

RangeEffect RangeStage::run(Time t_end, SideFilter* filter, const Vec3& g_odom_mps2,
                            const std::optional<SE3>& first_pose, OutputList& out) {
  RangeEffect effect;
  records_.clear();
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

/// A peer that drives off takes its place with it.
void RangeStage::forget_moved(SideFilter& filter) {
  std::vector<PlaceKey> gone;
  for (const auto& [key, place] : places_) {
    const Peer& peer = peers_.at(std::get<0>(key));
    if (peer.heard && !peer.at_rest) gone.push_back(key);
  }
  for (const PlaceKey& key : gone) {
    const int first = places_.at(key).side;
    places_.erase(key);
    in_passage_.erase(key);
    remove_states(first, 3, filter);
  }
  if (gone.empty()) return;
  for (auto& [key, pair] : pairs_) {
    pair.finder.reset();
    pair.sought.clear();
  }
}

void RangeStage::remove_states(int first, int n, SideFilter& filter) {
  filter.remove_side(first, n);
  const auto move_down = [first, n](int& index) {
    if (index >= first + n) index -= n;
  };
  for (auto& [key, place] : places_) move_down(place.side);
  for (auto& [key, pair] : pairs_) move_down(pair.bias);
  move_down(tau_);
}

void RangeStage::use(const RangeSample& sample, SideFilter& filter, RangeEffect& effect,
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
  const Peer& peer = peers_.at(std::get<1>(key));
  const bool stands =
      peer.heard && peer.at_rest && (sample.t - peer.t_status).s() < r.status_valid_s;
  std::optional<Prediction> prediction;
  if (now && stands) prediction = predict_known(*now, key, pair, filter);
  const double rate = prediction ? prediction->rate_mps : std::nan("");
  if (const auto wrong = pair.sanity.check(sample.t, sample.range_m, sigma_m, rate)) {
    use.reason = *wrong;
    return;
  }
  sigma_m *= signal.sigma_factor;
  if (!prediction) {
    use.reason = now || !stands ? RangeReason::kNoPose : RangeReason::kLate;
    if (now && stands) seek_place(key, *now, sample, sigma_m, filter);
    return;
  }
  bool clear = signal.clear();
  if (blocked(pair, sample.t, *prediction, filter)) {
    sigma_m *= r.sight.sigma_factor;
    use.p_los = std::isnan(use.p_los) ? r.signal.p_los_blocked
                                      : std::min(use.p_los, r.signal.p_los_blocked);
    clear = false;
  }
  RangeRecord record = record_of(key, pair, *now, sample, sigma_m);
  record.rate_mps = prediction->rate_mps;
  sigma_m = std::hypot(sigma_m, prediction->bent_sigma_m);
  judge(pair, sample, *prediction, sigma_m, clear, filter, use);
  if (use.used()) {
    const double inflation = pair.thinning.inflation(sample.t, sigma_m, now->at_rest);
    const Vec3 shift = filter.apply(prediction->measurement, pair.R_m2 * inflation);
    effect.shift_m += shift.norm();
    effect.from = std::get<1>(key);
    pair.inflation = inflation;
  }
  record.used = use.used();
  record.R_m2 = record.sigma_m * record.sigma_m * pair.inflation;
  records_.push_back(record);
}

/// The peer's place is known, or was measured by hand.
std::optional<RangeStage::Prediction> RangeStage::predict_known(const Moment& now,
                                                                const PairKey& key, Pair& pair,
                                                                SideFilter& filter) {
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  if (!places_.contains(place_key) && !place_from_prior(place_key, filter)) return std::nullopt;
  add_pair_states(pair, now.t, filter);
  walk(pair, now.t, filter);
  const int place = places_.at(place_key).side;
  auto prediction = predict(now, key, pair, place, filter);
  if (prediction && keep_in_passage(place_key, now, *prediction, filter)) {
    prediction = predict(now, key, pair, place, filter);
  }
  return prediction;
}

/// Steps, gate and link (algorithms 4.3, steps 4 to 6); `use` tells what came out.
void RangeStage::judge(Pair& pair, const RangeSample& sample, Prediction& prediction,
                       double sigma_m, bool clear, SideFilter& filter, RangeUse& use) {
  odometry::SideMeasurement& m = prediction.measurement;
  m.residual = sample.range_m - prediction.predicted_m;
  const double H_P_H = filter.variance(m);
  const double S = H_P_H + sigma_m * sigma_m;
  use.predicted_m = prediction.predicted_m;
  use.residual_m = m.residual;
  use.bias_m = prediction.bias_m;
  use.sigma_m = std::sqrt(S);
  if (is_excess(pair, sample.t, prediction, sigma_m, std::sqrt(H_P_H), filter)) {
    use.reason = RangeReason::kNlos;
    return;
  }
  const ranging::LinkDecision decision =
      pair.link.decide({sample.t, m.residual, S, sigma_m, clear});
  if (decision.advice == ranging::LinkAdvice::kWeAreWrong) filter.widen(decision.widen_factor);
  use.reason = decision.use ? RangeReason::kUsed : decision.reason;
  pair.R_m2 = decision.gate.R_m2;
}

RangeRecord RangeStage::record_of(const PairKey& key, const Pair& pair, const Moment& now,
                                  const RangeSample& sample, double sigma_m) {
  RangeRecord record;
  record.id = next_record_++;
  record.t = sample.t;
  record.T_odom_body = now.T_odom_body;
  record.p_body_antenna_m = settings_.antennas_body_m[std::get<0>(key)];
  record.range_m = sample.range_m;
  record.sigma_m = sigma_m;
  record.R_m2 = sigma_m * sigma_m;
  const auto place = places_.find(PlaceKey{std::get<1>(key), std::get<2>(key)});
  if (place != places_.end()) record.place = place->second.number;
  record.pair = pair.number;
  return record;
}

/// True while the range is longer than the straight way. If the track began with such ranges the
/// pose has followed them: it is as doubtful as they were wrong.
bool RangeStage::is_excess(Pair& pair, Time t, const Prediction& prediction, double sigma_m,
                           double pose_sigma_m, SideFilter& filter) const {
  if (!settings_.ranging.excess.use) return false;
  constexpr double kMemory_s = 0.5;  // of the level before a step, at 20 Hz
  const Vec3 sight = (prediction.p_odom_antenna_m - prediction.p_odom_peer_m).normalized();
  pair.sights.emplace_back(t, sight);
  while ((t - pair.sights.front().first).s() > kMemory_s) pair.sights.pop_front();
  const Vec3 turned = sight - pair.sights.front().second;
  const double turn_sigma_m = std::sqrt(turned.dot(prediction.P_between_m2 * turned));
  const ranging::ExcessVerdict verdict =
      pair.excess.look(t, prediction.measurement.residual, sigma_m, pose_sigma_m, turn_sigma_m);
  if (verdict == ranging::ExcessVerdict::kRelieved) {
    const double was = std::max(1e-3, pose_sigma_m);
    const double wrong = pair.excess.step_m();
    filter.widen(std::clamp(1.0 + wrong * wrong / (was * was), 1.0, kWidenMost));
    return false;
  }
  return verdict != ranging::ExcessVerdict::kNone;
}

/// What was measured by hand before the start, as long as the peer has not moved.
bool RangeStage::place_from_prior(const PlaceKey& key, SideFilter& filter) {
  const Peer& peer = peers_.at(std::get<0>(key));
  if (!peer.settings.prior || peer.moved || !first_pose_) return false;
  const PeerPrior& prior = *peer.settings.prior;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<1>(key)];
  const SE3 T_odom_start = level_start(*first_pose_, up_odom_);
  const Vec3 p = T_odom_start * (prior.T_self_peer * lever);
  // What is wrong with the heading moves the place across the line to it.
  const Vec3 arm = prior.sigma_rad * up_odom_.cross(p - T_odom_start.p);
  const Mat3 covariance = prior.sigma_m * prior.sigma_m * Mat3::Identity() + arm * arm.transpose();
  return add_place(key, p, covariance, filter);
}

/// Gathers ranges until they tell where the other antenna stands.
void RangeStage::seek_place(const PairKey& key, const Moment& now, const RangeSample& sample,
                            double sigma_m, SideFilter& filter) {
  Pair& pair = pair_of(key);
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  const Vec3 own = settings_.antennas_body_m[std::get<0>(key)];
  const Vec3 other = peers_.at(std::get<1>(key)).settings.antennas_body_m[std::get<2>(key)];
  pair.sought.push_back(record_of(key, pair, now, sample, sigma_m));
  RangeRecord& record = pair.sought.back();
  record.R_m2 *= pair.thinning.inflation(sample.t, sigma_m, now.at_rest);
  constexpr std::size_t kSoughtMax = 20'000;
  if (pair.sought.size() > kSoughtMax) pair.sought.pop_front();
  ranging::FinderSample s;
  s.t = sample.t;
  s.p_odom_antenna_m = now.T_odom_body * own;
  s.covariance_m2 = filter.position_covariance();
  s.passage_odom = filter.blind_axis();
  s.range_m = sample.range_m;
  s.sigma_m = sigma_m;
  const auto found = pair.finder.add(s, other.z() - own.z(), up_odom_);
  if (!found || !add_place(place_key, found->p_odom_m, found->covariance_m2, filter)) return;
  pair.finder.reset();
  // Whoever looks again begins without what these ranges told.
  const ranging::FinderSettings& f = settings_.ranging.finder;
  const double wide_m = sample.range_m + f.passage_m;
  place_records_.back().prior_covariance_m2 =
      wide_m * wide_m * Mat3::Identity() +
      (f.height_sigma_m * f.height_sigma_m - wide_m * wide_m) * up_odom_ * up_odom_.transpose();
  for (RangeRecord& sought : pair.sought) {
    sought.place = places_.at(place_key).number;
    sought.used = true;
    records_.push_back(sought);
  }
  pair.sought.clear();
}

bool RangeStage::add_place(const PlaceKey& key, const Vec3& p_odom_m, const Mat3& covariance_m2,
                           SideFilter& filter) {
  SideStates::Vector mean = p_odom_m;
  SideStates::Matrix covariance = covariance_m2;
  const int side = filter.add_side(mean, covariance);
  if (side < 0) return false;
  const int number = next_place_++;
  places_.emplace(key, Place{side, number});
  place_records_.push_back({number, p_odom_m, covariance_m2});
  return true;
}

/// Along a passage the other's place across it does not matter from afar, and is not known; near it
/// decides, and distances are no linear function of it. Before that: it stands in the passage. On
/// which side makes no difference, but a side it must be.
bool RangeStage::keep_in_passage(const PlaceKey& key, const Moment& now,
                                 const Prediction& prediction, SideFilter& filter) {
  const ranging::FinderSettings& f = settings_.ranging.finder;
  const double near_m = 1.0 / std::max(1e-3, f.passage_per_m);
  if (prediction.predicted_m > near_m || in_passage_.contains(key)) return false;
  const std::optional<Vec3> axis = filter.blind_axis();
  if (!axis) return false;
  in_passage_.insert(key);
  const Vec3 across = up_odom_.cross(*axis).normalized();
  const double sigma_m = std::sqrt(across.dot(prediction.P_between_m2 * across));
  if (sigma_m < 0.5 * f.passage_m) return false;
  const int place = places_.at(key).side;
  const Vec3 p = now.T_odom_body.p;
  const double aside_m = across.dot(filter.side().mean.segment<3>(place) - p);
  odometry::SideMeasurement m;
  m.d_side = SideStates::Vector::Zero(filter.side().size());
  m.d_side.segment<3>(place) = across;
  m.residual = std::copysign(0.5 * f.passage_m, aside_m) - aside_m;
  filter.apply(m, 0.5 * f.passage_m * f.passage_m);
  return true;
}

void RangeStage::add_pair_states(Pair& pair, Time t, SideFilter& filter) {
  const auto add = [&filter](double mean, double sigma) {
    SideStates::Vector m(1);
    m[0] = mean;
    SideStates::Matrix c(1, 1);
    c(0, 0) = sigma * sigma;
    return filter.add_side(m, c);
  };
  if (tau_ < 0) {
    tau_ = add(0.0, settings_.ranging.bias.tau_sigma_s);
    t_tau_ = t;
  }
  if (pair.bias < 0) {
    pair.bias = add(pair.bias_m, pair.bias_sigma_m);
    pair.t_bias = t;
  }
}

void RangeStage::walk(Pair& pair, Time t, SideFilter& filter) {
  const ranging::BiasSettings& b = settings_.ranging.bias;
  const auto step = [&](int index, Time& last, double walk) {
    if (index >= 0 && t > last) filter.walk_side(index, walk * walk * (t - last).s());
    last = std::max(last, t);
  };
  step(pair.bias, pair.t_bias, b.walk_m_rts);
  step(tau_, t_tau_, b.tau_walk_s_rts);
}

/// u = rho + b + tau drho/dt (algorithms 4.1), and how it moves with the filter's state.
std::optional<RangeStage::Prediction> RangeStage::predict(const Moment& now, const PairKey& key,
                                                          const Pair& pair, int place,
                                                          const SideFilter& filter) const {
  const SideStates& side = filter.side();
  Prediction out;
  out.p_odom_peer_m = side.mean.segment<3>(place);
  const ranging::RangeEnd own{now.T_odom_body, settings_.antennas_body_m[std::get<0>(key)],
                              now.v_odom_mps, now.w_body_radps};
  const auto p = ranging::predict(own, out.p_odom_peer_m, settings_.ranging.limits.near_m);
  if (!p) return std::nullopt;
  out.p_odom_antenna_m = own.antenna_odom_m();
  out.P_between_m2 = filter.position_covariance() + side.covariance.block<3, 3>(place, place);
  out.rate_mps = p->rate_mps;
  // Near the antenna, by the doubt about where it is, a distance is no linear function of the
  // place: mean and variance of the second-order term.
  const Mat3 across = Mat3::Identity() - p->e * p->e.transpose();
  const Mat3 M = across * out.P_between_m2 * across / p->rho_m;
  const double bend_m = 0.5 * M.trace();
  out.bent_sigma_m = std::sqrt(0.5 * (M * M).trace());
  out.predicted_m = p->rho_m + bend_m;
  odometry::SideMeasurement& m = out.measurement;
  m.d_pose.head<3>() = p->d_theta_j;
  m.d_pose.tail<3>() = p->d_p_j;
  m.d_side = SideStates::Vector::Zero(side.size());
  m.d_side.segment<3>(place) = p->d_p_k.transpose();
  // From afar only the distance is learned: what a slow error or a bend tells about the place
  // across the line would be believed too soon.
  if (p->rho_m > 1.0 / std::max(1e-3, settings_.ranging.finder.passage_per_m)) {
    m.considered = place;
    m.estimates = p->e * p->e.transpose();
  }
  if (pair.bias >= 0) {
    out.bias_m = side.mean[pair.bias];
    m.d_side[pair.bias] = 1.0;
  }
  out.predicted_m += out.bias_m;
  if (tau_ >= 0) {
    out.predicted_m += side.mean[tau_] * p->rate_mps;
    m.d_side[tau_] = p->rate_mps;
    m.d_velocity = side.mean[tau_] * p->d_p_j;
  }
  return out;
}

/// Asked again after a while or some way: marching through the map costs more than the rest. Where
/// the pose is doubtful along the map, the walls must be in the way at both ends of the doubt too.
bool RangeStage::blocked(Pair& pair, Time t, const Prediction& prediction,
                         const SideFilter& filter) const {
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
  const Mat3 P = filter.position_covariance();
  const Vec3 spread = 2.0 * P.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (const double side : {0.0, -1.0, 1.0}) {
    const Vec3 from = p + end + side * spread;
    if (filter.surfaces_between(from, q - end) < s.surfaces) return false;
  }
  pair.blocked = true;
  return true;
}

}  // namespace rali::vehicle
