#include <algorithm>
#include <cmath>

#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using odometry::AugmentedStates;
using odometry::Moment;
using sensor::RangeSample;

/// Removes the landmark of a peer that drives off, and the ranges gathered to find it. One that
/// reports motion only for a moment, since somebody passed in front of its LiDAR, keeps it:
/// initialised again by the report, it was on the wrong side.
void RangeStage::forget_moved(AugmentedFilter& filter) {
  for (auto& [id, peer] : peers_) {
    if (!peer.gone) continue;
    peer.gone = peer.left;
    std::vector<LandmarkKey> gone;
    for (const auto& [key, place] : places_) {
      if (std::get<0>(key) == id) gone.push_back(key);
    }
    for (const LandmarkKey& key : gone) {
      const int first = places_.at(key).state_index;
      places_.erase(key);
      lost_.erase(key);
      remove_states(first, 3, filter);
    }
    for (auto& [key, pair] : pairs_) {
      if (std::get<1>(key) == id) pair.finder.reset();
    }
  }
}

void RangeStage::remove_states(int first, int n, AugmentedFilter& filter) {
  filter.remove_states(first, n);
  const auto move_down = [first, n](int& index) {
    if (index >= first + n) index -= n;
  };
  for (auto& [key, place] : places_) move_down(place.state_index);
  for (auto& [key, pair] : pairs_) move_down(pair.bias);
  move_down(tau_);
}

/// Ranges come and none can be used: the landmark, or the pose, is so wrong that linear updates do
/// not correct it. Initialised again, the landmark constrains at least the path from here on.
void RangeStage::forget_unfit(const LandmarkKey& key, Pair& pair, Time t, bool fits,
                              AugmentedFilter& filter) {
  const bool silent =
      !pair.t_received || (t - *pair.t_received).s() > settings_.ranging.place_silent_s;
  pair.t_received = t;
  if (fits || silent || !pair.t_fit) pair.t_fit = t;
  const auto found = places_.find(key);
  if (found == places_.end()) return;
  if ((t - *pair.t_fit).s() < settings_.ranging.place_lost_s) return;
  const int state_index = found->second.state_index;
  lost_.insert(key);
  places_.erase(found);
  remove_states(state_index, 3, filter);
  pair.t_fit.reset();
  pair.finder.reset();
  pair.excess.reset();
}

/// A peer at standstill has a landmark by ranges. One in motion has none, but reports its pose. A
/// column in a tunnel sees nothing else along it, and would take its own vehicles for static
/// objects.
std::map<RangeStage::LandmarkKey, KnownLandmark> RangeStage::known(const AugmentedFilter& filter,
                                                                   Time t,
                                                                   double sigma_max_m) const {
  std::map<LandmarkKey, KnownLandmark> out;
  const Mat3 P_own = filter.position_covariance();
  const auto add = [&](const LandmarkKey& key, const Vec3& p_odom_m, const Mat3& P) {
    if (P.diagonal().maxCoeff() <= sigma_max_m * sigma_max_m)
      out.emplace(key, KnownLandmark{p_odom_m, P});
  };
  for (const auto& [key, place] : places_) {
    add(key, filter.augmented().mean.segment<3>(place.state_index), between(place, filter));
  }
  for (const auto& [id, peer] : peers_) {
    if (!first_pose_ || !peer.received || peer.at_rest || !peer.pose) continue;
    if (std::abs((t - peer.t_status).s()) > settings_.ranging.status_valid_s) continue;
    for (std::size_t k = 0; k < peer.settings.antennas_body_m.size(); ++k) {
      const auto place = place_of(peer, peer.settings.antennas_body_m[k], *first_pose_, up_odom_);
      if (!place) continue;
      add({id, static_cast<std::uint8_t>(k)}, place->p_odom_m, P_own + place->covariance_m2);
    }
  }
  return out;
}

std::vector<KnownLandmark> RangeStage::places(const AugmentedFilter& filter, Time t,
                                              double sigma_max_m) const {
  std::vector<KnownLandmark> out;
  for (const auto& [key, place] : known(filter, t, sigma_max_m)) out.push_back(place);
  return out;
}

std::vector<ReceivedPeer> RangeStage::unplaced(const AugmentedFilter& filter, Time t,
                                               double sigma_max_m) const {
  const auto placed = known(filter, t, sigma_max_m);
  std::vector<ReceivedPeer> out;
  for (const auto& [key, pair] : pairs_) {
    const auto& [own, peer, antenna] = key;
    const bool lately = pair.received &&
                        std::abs((t - pair.received->first).s()) < settings_.ranging.status_valid_s;
    if (!lately || placed.contains({peer, antenna})) continue;
    out.push_back({settings_.antennas_body_m[own], pair.received->second});
  }
  return out;
}

/// Initialises the landmark first if it can without further ranges; empty if there is none.
std::optional<RangeStage::Prediction> RangeStage::predict_known(const Moment& now,
                                                                const PairKey& key, Pair& pair,
                                                                const RangeSample& sample,
                                                                double sigma_m,
                                                                AugmentedFilter& filter) {
  const LandmarkKey landmark_key{std::get<1>(key), std::get<2>(key)};
  if (!places_.contains(landmark_key) && !place_from_prior(landmark_key, filter) &&
      !initialise_by_lateral_offset(key, now, sample, sigma_m, filter) &&
      !initialise_from_peer(key, now, sample, sigma_m, filter)) {
    return std::nullopt;
  }
  add_pair_states(pair, now.t, filter);
  walk(pair, now.t, filter);
  Place& place = places_.at(landmark_key);
  measure_lateral_offset(key, place, now, filter);
  auto prediction = predict(now, key, pair, place, filter);
  if (prediction && place.along.isZero(0.0)) {
    place.along = (prediction->p_odom_antenna_m - prediction->p_odom_peer_m).normalized();
  }
  if (prediction) enter_passage(place, prediction->P_between_m2, now, filter);
  if (prediction && place.passage) predict_in_passage(key, place, now, filter, *prediction);
  // Near an antenna of uncertain position a linear update can make no use of a range.
  const bool bent = prediction && prediction->bent_sigma_m > settings_.ranging.limits.bent_max_m;
  return bent ? std::nullopt : prediction;
}

void RangeStage::add_pair_states(Pair& pair, Time t, AugmentedFilter& filter) {
  const auto add = [&filter](double mean, double sigma) {
    AugmentedStates::Vector m(1);
    m[0] = mean;
    AugmentedStates::Matrix c(1, 1);
    c(0, 0) = sigma * sigma;
    return filter.add_states(m, c, {});
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

void RangeStage::walk(Pair& pair, Time t, AugmentedFilter& filter) {
  const ranging::BiasSettings& b = settings_.ranging.bias;
  const auto step = [&](int index, Time& last, double walk) {
    if (index >= 0 && t > last) filter.walk_side(index, walk * walk * (t - last).s());
    last = std::max(last, t);
  };
  step(pair.bias, pair.t_bias, b.walk_m_rts);
  step(tau_, t_tau_, b.tau_walk_s_rts);
}

/// u = rho + b + tau drho/dt (algorithms 4.1), and its derivatives by the filter's state.
std::optional<RangeStage::Prediction> RangeStage::predict(const Moment& now, const PairKey& key,
                                                          const Pair& pair, const Place& received,
                                                          const AugmentedFilter& filter) const {
  const AugmentedStates& augmented = filter.augmented();
  const int place = received.state_index;
  Prediction out;
  out.place = place;
  out.at_rest = now.at_rest;
  out.p_odom_peer_m = augmented.mean.segment<3>(place);
  const ranging::RangeEnd own{now.T_odom_body, settings_.antennas_body_m[std::get<0>(key)],
                              now.v_odom_mps, now.w_body_radps};
  const auto p = ranging::predict(own, out.p_odom_peer_m, settings_.ranging.limits.near_m);
  if (!p) return std::nullopt;
  out.p_odom_antenna_m = own.antenna_odom_m();
  out.P_between_m2 = between(received, filter);
  out.rate_mps = p->rate_mps;
  // Near an antenna of uncertain position, a distance is not linear in the position: sigma of the
  // second-order term.
  const Mat3 across = Mat3::Identity() - p->e * p->e.transpose();
  const Mat3 M = across * out.P_between_m2 * across / p->rho_m;
  out.bent_sigma_m = std::sqrt(0.5 * (M * M).trace());
  out.predicted_m = p->rho_m;
  odometry::AugmentedMeasurement& m = out.measurement;
  m.d_pose.head<3>() = p->d_theta_j;
  m.d_pose.tail<3>() = p->d_p_j;
  m.d_augmented = AugmentedStates::Vector::Zero(augmented.size());
  m.d_augmented.segment<3>(place) = p->d_p_k.transpose();
  // From afar only the distance is estimated: slow errors and bends would too soon determine the
  // position across the line of sight.
  const bool far = p->rho_m > 1.0 / std::max(1e-3, settings_.ranging.finder.passage_per_m);
  if (far || received.passed) {
    // One direction for all of them: many that differ a little would determine it in the end.
    const Vec3 along = received.along.isZero(0.0) ? p->e : received.along;
    m.considered = place;
    m.estimates = along * along.transpose();
  }
  if (pair.bias >= 0) {
    out.bias_m = augmented.mean[pair.bias];
    m.d_augmented[pair.bias] = 1.0;
  }
  out.predicted_m += out.bias_m;
  if (tau_ >= 0) {
    out.predicted_m += augmented.mean[tau_] * p->rate_mps;
    m.d_augmented[tau_] = p->rate_mps;
    m.d_velocity = augmented.mean[tau_] * p->d_p_j;
  }
  return out;
}

}  // namespace rali::vehicle
