#include <algorithm>
#include <cmath>

#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::Moment;
using odometry::SideFilter;
using odometry::SideStates;
using sensor::RangeSample;

namespace {

/// Sigma along the blind axis of what a vehicle that has moved says of its way: as good as nothing.
/// It knows that way by ranges to this one, among others, and is no second opinion: vehicles that
/// took each other for one stated 0.2 m where they were 1.6 m off after 100 m. Where it stands to
/// this one is learned by ranges.
constexpr double kToldSigma_m = 20.0;

}  // namespace

/// A peer that drives off takes its place with it.
void RangeStage::forget_moved(SideFilter& filter) {
  std::vector<PlaceKey> gone;
  for (const auto& [key, place] : places_) {
    const PeerWatch& peer = peers_.at(std::get<0>(key));
    if (peer.heard && !peer.at_rest) gone.push_back(key);
  }
  for (const PlaceKey& key : gone) {
    const int first = places_.at(key).side;
    places_.erase(key);
    lost_.erase(key);
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

/// Ranges come and none can be used: the place, or the pose, is so wrong that linear updates do not
/// mend it. Sought anew, the other's place at least holds the way from here on; the second look
/// knows that it is the same place.
void RangeStage::forget_unfit(const PlaceKey& key, Pair& pair, Time t, bool fits,
                              SideFilter& filter) {
  const bool silent = !pair.t_heard || (t - *pair.t_heard).s() > settings_.ranging.place_silent_s;
  pair.t_heard = t;
  if (fits || silent || !pair.t_fit) pair.t_fit = t;
  const auto found = places_.find(key);
  if (found == places_.end()) return;
  if ((t - *pair.t_fit).s() < settings_.ranging.place_lost_s) return;
  const Place place = found->second;
  lost_[key] = place.number;
  places_.erase(found);
  remove_states(place.side, 3, filter);
  pair.t_fit.reset();
  pair.finder.reset();
  pair.sought.clear();
  pair.excess.reset();
}

/// Who stands has a place by ranges. Who drives has none, but says of its way where it is: a column
/// in a tunnel sees nothing else along it, and its own vehicles would be taken for what stands
/// still.
std::map<RangeStage::PlaceKey, KnownPlace> RangeStage::known(const SideFilter& filter, Time t,
                                                             double sigma_max_m) const {
  std::map<PlaceKey, KnownPlace> out;
  const Mat3 P_own = filter.position_covariance();
  const auto add = [&](const PlaceKey& key, const Vec3& p_odom_m, const Mat3& covariance_m2) {
    const Mat3 P = P_own + covariance_m2;
    if (P.diagonal().maxCoeff() <= sigma_max_m * sigma_max_m)
      out.emplace(key, KnownPlace{p_odom_m, P});
  };
  const SideStates& side = filter.side();
  for (const auto& [key, place] : places_) {
    add(key, side.mean.segment<3>(place.side), side.covariance.block<3, 3>(place.side, place.side));
  }
  for (const auto& [id, peer] : peers_) {
    if (!first_pose_ || !peer.heard || peer.at_rest || !peer.pose) continue;
    if (std::abs((t - peer.t_status).s()) > settings_.ranging.status_valid_s) continue;
    for (std::size_t k = 0; k < peer.settings.antennas_body_m.size(); ++k) {
      const auto place = place_of(peer, peer.settings.antennas_body_m[k], *first_pose_, up_odom_);
      if (place) add({id, static_cast<std::uint8_t>(k)}, place->p_odom_m, place->covariance_m2);
    }
  }
  return out;
}

std::vector<KnownPlace> RangeStage::places(const SideFilter& filter, Time t,
                                           double sigma_max_m) const {
  std::vector<KnownPlace> out;
  for (const auto& [key, place] : known(filter, t, sigma_max_m)) out.push_back(place);
  return out;
}

std::vector<HeardPeer> RangeStage::unplaced(const SideFilter& filter, Time t,
                                            double sigma_max_m) const {
  const auto placed = known(filter, t, sigma_max_m);
  std::vector<HeardPeer> out;
  for (const auto& [key, pair] : pairs_) {
    const auto& [own, peer, antenna] = key;
    const bool lately =
        pair.heard && std::abs((t - pair.heard->first).s()) < settings_.ranging.status_valid_s;
    if (!lately || placed.contains({peer, antenna})) continue;
    out.push_back({settings_.antennas_body_m[own], pair.heard->second});
  }
  return out;
}

/// The peer's place is known, or was measured by hand.
std::optional<RangeStage::Prediction> RangeStage::predict_known(const Moment& now,
                                                                const PairKey& key, Pair& pair,
                                                                SideFilter& filter) {
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  if (!places_.contains(place_key) && !place_from_prior(place_key, filter)) return std::nullopt;
  add_pair_states(pair, now.t, filter);
  walk(pair, now.t, filter);
  Place& place = places_.at(place_key);
  auto prediction = predict(now, key, pair, place, filter);
  if (prediction && place.along.isZero(0.0)) {
    place.along = (prediction->p_odom_antenna_m - prediction->p_odom_peer_m).normalized();
  }
  if (prediction) enter_passage(place, now, filter);
  if (prediction && place.passage) predict_in_passage(key, place, now, filter, *prediction);
  // Near an antenna of doubtful place a range says nothing that a linear update could use.
  const bool bent = prediction && prediction->bent_sigma_m > settings_.ranging.limits.bent_max_m;
  return bent ? std::nullopt : prediction;
}

/// What was measured by hand before the start, and what the peer said of its way since: of that,
/// along the blind axis, no more than about where.
bool RangeStage::place_from_prior(const PlaceKey& key, SideFilter& filter) {
  const PeerWatch& peer = peers_.at(std::get<0>(key));
  if (lost_.contains(key) || !first_pose_) return false;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<1>(key)];
  const std::optional<KnownPlace> place = place_of(peer, lever, *first_pose_, up_odom_);
  if (!place) return false;
  Mat3 covariance_m2 = place->covariance_m2;
  const std::optional<Vec3> blind = filter.blind_axis();
  if (peer.moved && blind) {
    covariance_m2 += kToldSigma_m * kToldSigma_m * *blind * blind->transpose();
  }
  return add_place(key, place->p_odom_m, covariance_m2, filter);
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
  if (!found) return;
  // It was found from the own way: what that is wrong by, the place is wrong by.
  const Mat3 covariance = found->covariance_m2 + filter.position_covariance();
  if (!add_place(place_key, found->p_odom_m, covariance, filter)) return;
  pair.finder.reset();
  // Whoever looks again begins without what these ranges told.
  const ranging::FinderSettings& f = settings_.ranging.finder;
  const double wide_m = sample.range_m + f.passage_m;
  const bool again = lost_.contains(place_key);
  if (!again) {
    place_records_.back().prior_covariance_m2 =
        wide_m * wide_m * Mat3::Identity() +
        (f.height_sigma_m * f.height_sigma_m - wide_m * wide_m) * up_odom_ * up_odom_.transpose();
  }
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
  const auto lost = lost_.find(key);
  if (lost != lost_.end()) {
    places_.emplace(key, Place{side, lost->second, Vec3::Zero(), std::nullopt, false});
    return true;
  }
  const int number = next_place_++;
  places_.emplace(key, Place{side, number, Vec3::Zero(), std::nullopt, false});
  place_records_.push_back({number, p_odom_m, covariance_m2});
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
                                                          const Pair& pair, const Place& heard,
                                                          const SideFilter& filter) const {
  const SideStates& side = filter.side();
  const int place = heard.side;
  Prediction out;
  out.place = place;
  out.at_rest = now.at_rest;
  out.p_odom_peer_m = side.mean.segment<3>(place);
  const ranging::RangeEnd own{now.T_odom_body, settings_.antennas_body_m[std::get<0>(key)],
                              now.v_odom_mps, now.w_body_radps};
  const auto p = ranging::predict(own, out.p_odom_peer_m, settings_.ranging.limits.near_m);
  if (!p) return std::nullopt;
  out.p_odom_antenna_m = own.antenna_odom_m();
  out.P_between_m2 = filter.position_covariance() + side.covariance.block<3, 3>(place, place);
  out.rate_mps = p->rate_mps;
  // Near the antenna, by the doubt about where it is, a distance is no linear function of the
  // place: sigma of the second-order term.
  const Mat3 across = Mat3::Identity() - p->e * p->e.transpose();
  const Mat3 M = across * out.P_between_m2 * across / p->rho_m;
  out.bent_sigma_m = std::sqrt(0.5 * (M * M).trace());
  out.predicted_m = p->rho_m;
  odometry::SideMeasurement& m = out.measurement;
  m.d_pose.head<3>() = p->d_theta_j;
  m.d_pose.tail<3>() = p->d_p_j;
  m.d_side = SideStates::Vector::Zero(side.size());
  m.d_side.segment<3>(place) = p->d_p_k.transpose();
  // From afar only the distance is learned: what a slow error or a bend tells about the place
  // across the line would be believed too soon.
  const bool far = p->rho_m > 1.0 / std::max(1e-3, settings_.ranging.finder.passage_per_m);
  if (far || heard.passed) {
    // One line for all of them: many lines that turn a little would tell the same in the end.
    const Vec3 along = heard.along.isZero(0.0) ? p->e : heard.along;
    m.considered = place;
    m.estimates = along * along.transpose();
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

}  // namespace rali::vehicle
