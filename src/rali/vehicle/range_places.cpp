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

/// A peer that drives off takes its place with it. One that only says for a moment that it does,
/// since somebody passed in front of its LiDAR, does not: found again by its word it was on the
/// wrong side.
void RangeStage::forget_moved(SideFilter& filter) {
  std::vector<PlaceKey> gone;
  for (const auto& [key, place] : places_) {
    const PeerWatch& peer = peers_.at(std::get<0>(key));
    if (peer.left) gone.push_back(key);
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
/// mend it. Sought anew, the other's place at least holds the way from here on.
void RangeStage::forget_unfit(const PlaceKey& key, Pair& pair, Time t, bool fits,
                              SideFilter& filter) {
  const bool silent = !pair.t_heard || (t - *pair.t_heard).s() > settings_.ranging.place_silent_s;
  pair.t_heard = t;
  if (fits || silent || !pair.t_fit) pair.t_fit = t;
  const auto found = places_.find(key);
  if (found == places_.end()) return;
  if ((t - *pair.t_fit).s() < settings_.ranging.place_lost_s) return;
  const int side = found->second.side;
  lost_.insert(key);
  places_.erase(found);
  remove_states(side, 3, filter);
  pair.t_fit.reset();
  pair.finder.reset();
  pair.excess.reset();
}

/// Who stands has a place by ranges. Who drives has none, but says of its way where it is: a column
/// in a tunnel sees nothing else along it, and its own vehicles would be taken for what stands
/// still.
std::map<RangeStage::PlaceKey, KnownPlace> RangeStage::known(const SideFilter& filter, Time t,
                                                             double sigma_max_m) const {
  std::map<PlaceKey, KnownPlace> out;
  const Mat3 P_own = filter.position_covariance();
  const auto add = [&](const PlaceKey& key, const Vec3& p_odom_m, const Mat3& P) {
    if (P.diagonal().maxCoeff() <= sigma_max_m * sigma_max_m)
      out.emplace(key, KnownPlace{p_odom_m, P});
  };
  for (const auto& [key, place] : places_) {
    add(key, filter.side().mean.segment<3>(place.side), between(place, filter));
  }
  for (const auto& [id, peer] : peers_) {
    if (!first_pose_ || !peer.heard || peer.at_rest || !peer.pose) continue;
    if (std::abs((t - peer.t_status).s()) > settings_.ranging.status_valid_s) continue;
    for (std::size_t k = 0; k < peer.settings.antennas_body_m.size(); ++k) {
      const auto place = place_of(peer, peer.settings.antennas_body_m[k], *first_pose_, up_odom_);
      if (!place) continue;
      add({id, static_cast<std::uint8_t>(k)}, place->p_odom_m, P_own + place->covariance_m2);
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
                                                                const RangeSample& sample,
                                                                double sigma_m,
                                                                SideFilter& filter) {
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  if (!places_.contains(place_key) && !place_from_prior(place_key, filter) &&
      !place_by_side(key, now, sample, sigma_m, filter) &&
      !place_by_other(key, now, sample, sigma_m, filter)) {
    return std::nullopt;
  }
  add_pair_states(pair, now.t, filter);
  walk(pair, now.t, filter);
  Place& place = places_.at(place_key);
  measure_aside(key, place, now, filter);
  auto prediction = predict(now, key, pair, place, filter);
  if (prediction && place.along.isZero(0.0)) {
    place.along = (prediction->p_odom_antenna_m - prediction->p_odom_peer_m).normalized();
  }
  if (prediction) enter_passage(place, prediction->P_between_m2, now, filter);
  if (prediction && place.passage) predict_in_passage(key, place, now, filter, *prediction);
  // Near an antenna of doubtful place a range says nothing that a linear update could use.
  const bool bent = prediction && prediction->bent_sigma_m > settings_.ranging.limits.bent_max_m;
  return bent ? std::nullopt : prediction;
}

void RangeStage::add_pair_states(Pair& pair, Time t, SideFilter& filter) {
  const auto add = [&filter](double mean, double sigma) {
    SideStates::Vector m(1);
    m[0] = mean;
    SideStates::Matrix c(1, 1);
    c(0, 0) = sigma * sigma;
    return filter.add_side(m, c, {});
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
  out.P_between_m2 = between(heard, filter);
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
