#include <cmath>

#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::Moment;
using odometry::SideFilter;
using odometry::SideMeasurement;
using odometry::SideRowList;
using odometry::SideStates;
using sensor::RangeSample;

/// The own position, as a function of the filter's state.
SideRowList RangeStage::own_position(const SideFilter& filter) {
  SideRowList rows(3);
  for (int k = 0; k < 3; ++k) {
    SideMeasurement& row = rows[static_cast<std::size_t>(k)];
    row.d_side = SideStates::Vector::Zero(filter.side().size());
    row.d_pose[3 + k] = 1.0;
  }
  return rows;
}

/// Covariance of how far the place is from the vehicle: who was found from the own way errs with
/// it.
Mat3 RangeStage::between(const Place& place, const SideFilter& filter) const {
  SideRowList rows = own_position(filter);
  for (int k = 0; k < 3; ++k) rows[static_cast<std::size_t>(k)].d_side[place.side + k] = -1.0;
  return filter.covariance(rows);
}

/// What was measured by hand before the start, and what the peer said of its way since.
bool RangeStage::place_from_prior(const PlaceKey& key, SideFilter& filter) {
  const PeerWatch& peer = peers_.at(std::get<0>(key));
  // Along a blind way it knows itself by ranges only, ranges to this vehicle among them.
  const bool by_ranges = peer.moved && filter.blind_axis();
  if (lost_.contains(key) || !first_pose_ || by_ranges) return false;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<1>(key)];
  const std::optional<KnownPlace> place = place_of(peer, lever, *first_pose_, up_odom_);
  return place && add_place(key, place->p_odom_m, place->covariance_m2, {}, filter);
}

/// A peer that has moved knows where it is along a blind way by ranges to this vehicle, among
/// others: it is no second opinion. Vehicles that took each other for one stated 0.2 m where they
/// were 1.6 m off after 100 m. Of its word about the way the side is taken, ahead or behind, if the
/// word leaves no doubt of that; how far, the range tells, as a measurement, once the place is
/// roughly there. Across it each knows itself by its own LiDAR.
bool RangeStage::place_by_side(const PairKey& key, const Moment& now, const RangeSample& sample,
                               double sigma_m, SideFilter& filter) {
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  const PeerWatch& peer = peers_.at(std::get<1>(key));
  const bool by_ranges = peer.moved && filter.blind_axis();
  if (!by_ranges || !first_pose_ || lost_.contains(place_key)) return false;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<2>(key)];
  const std::optional<KnownPlace> told = place_of(peer, lever, *first_pose_, up_odom_);
  Pair& pair = pair_of(key);
  if (!told || !agrees(pair, sample, now.v_odom_mps.norm())) return false;
  const ranging::FinderSample seen = finder_sample(key, now, sample, sigma_m, filter);
  const SideRowList own = own_position(filter);
  const Vec3 apart = told->p_odom_m - seen.p_odom_antenna_m;
  const Mat3 apart_m2 = told->covariance_m2 + filter.covariance(own);
  const auto told_along = [&](const Vec3& d) { return Told{d.dot(apart), d.dot(apart_m2 * d)}; };
  const Vec3& axis = *seen.passage_odom;
  const Told ahead = told_along(axis);
  const auto aside = aside_as_told(
      told_along(up_odom_.cross(axis).normalized()),
      ranging::aside_in_passage(settings_.ranging.finder, seen.by_walls, sample.range_m));
  if (!aside) return false;
  const double bias_m = pair.bias >= 0 ? filter.side().mean[pair.bias] : pair.bias_m;
  ranging::FoundAnchor place =
      ranging::place_along_passage(settings_.ranging.finder, seen, height_of(key), bias_m, up_odom_,
                                   ahead.value_m > 0.0, *aside);
  const Told there{axis.dot(place.p_odom_m - seen.p_odom_antenna_m),
                   axis.dot(place.covariance_m2 * axis)};
  if (!tells_side(ahead, there)) return false;
  const double roughly_m = settings_.ranging.finder.roughly_m;
  place.covariance_m2 += roughly_m * roughly_m * axis * axis.transpose();
  if (!add_place(place_key, place.p_odom_m, place.covariance_m2, own, filter)) return false;
  places_.at(place_key).aside_sigma_m = aside_sigma_m(seen);
  pair.finder.reset();
  return true;
}

/// What the passage leaves and what the other says of itself, together; nothing if they contradict
/// each other.
std::optional<ranging::Aside> RangeStage::aside_as_told(const Told& told,
                                                        const ranging::Aside& passage) const {
  const double tell_sigmas = settings_.ranging.finder.tell_sigmas;
  const double passage_m2 = passage.sigma_m * passage.sigma_m;
  const double both_m2 = passage_m2 + told.variance_m2;
  const double off_m = told.value_m - passage.mean_m;
  if (off_m * off_m > tell_sigmas * tell_sigmas * both_m2) return std::nullopt;
  const double share = passage_m2 / both_m2;
  return ranging::Aside{passage.mean_m + share * off_m, std::sqrt(share * told.variance_m2)};
}

/// One range in a row of its like: a wild one must not say where the other stands.
bool RangeStage::agrees(const Pair& pair, const RangeSample& sample, double speed_mps) const {
  if (!pair.heard) return false;
  const double dt_s = (sample.t - pair.heard->first).s();
  const double sigma_m =
      ranging::sigma_of(sample.range_m, settings_.ranging.limits, sample.sigma_m);
  return dt_s >= 0.0 && dt_s < settings_.ranging.place_silent_s &&
         std::abs(sample.range_m - pair.heard->second) <
             settings_.ranging.sanity.jump_sigmas * sigma_m + speed_mps * dt_s;
}

/// @param there where the range leads on the side that the other told
bool RangeStage::tells_side(const Told& told, const Told& there) const {
  const double S = told.variance_m2 + there.variance_m2;
  const double off_m = told.value_m - there.value_m;
  const double off_other_m = told.value_m + there.value_m;
  // Near by, the passage is as wide as the way to the other is long.
  const double bent_max_m = settings_.ranging.limits.bent_max_m;
  const double tell_sigmas = settings_.ranging.finder.tell_sigmas;
  return there.variance_m2 < bent_max_m * bent_max_m &&
         off_m * off_m < tell_sigmas * tell_sigmas * S &&
         (off_other_m * off_other_m - off_m * off_m) / S > settings_.ranging.finder.rival_chi2;
}

ranging::FinderSample RangeStage::finder_sample(const PairKey& key, const Moment& now,
                                                const RangeSample& sample, double sigma_m,
                                                const SideFilter& filter) const {
  ranging::FinderSample s;
  s.t = sample.t;
  s.p_odom_antenna_m = now.T_odom_body * settings_.antennas_body_m[std::get<0>(key)];
  s.covariance_m2 = filter.position_covariance();
  s.passage_odom = filter.blind_axis();
  if (s.passage_odom) {
    s.by_walls = aside_by_walls({std::get<1>(key), std::get<2>(key)}, s.p_odom_antenna_m,
                                *s.passage_odom, filter);
  }
  s.range_m = sample.range_m;
  s.sigma_m = sigma_m;
  return s;
}

/// How much higher the other antenna is where both vehicles stand level.
double RangeStage::height_of(const PairKey& key) const {
  const auto& [own, peer, antenna] = key;
  return peers_.at(peer).settings.antennas_body_m[antenna].z() - settings_.antennas_body_m[own].z();
}

/// How far aside the other is was in what found it.
double RangeStage::aside_sigma_m(const ranging::FinderSample& seen) const {
  return ranging::aside_in_passage(settings_.ranging.finder, seen.by_walls, seen.range_m).sigma_m;
}

/// Gathers ranges until they tell where the other antenna stands.
void RangeStage::seek_place(const PairKey& key, const Moment& now, const RangeSample& sample,
                            double sigma_m, SideFilter& filter) {
  Pair& pair = pair_of(key);
  const PlaceKey place_key{std::get<1>(key), std::get<2>(key)};
  // Ranges soon after it share its errors: the thinning counts it although it only locates the
  // peer.
  static_cast<void>(pair.thinning.inflation(sample.t, sigma_m, now.at_rest));
  const ranging::FinderSample seen = finder_sample(key, now, sample, sigma_m, filter);
  const auto found = pair.finder.add(seen, height_of(key), up_odom_);
  if (!found) return;
  if (!add_found(place_key, *found, pair, now.t, filter)) return;
  places_.at(place_key).aside_sigma_m = aside_sigma_m(seen);
  pair.finder.reset();
}

/// It was found from the own way, with the pair's bias: what those are wrong by, the place is wrong
/// by. Told apart from the bias, each new place would halve the doubt about that, and the doubt
/// about the way with it.
bool RangeStage::add_found(const PlaceKey& key, const ranging::FoundAnchor& found, Pair& pair,
                           Time t, SideFilter& filter) {
  add_pair_states(pair, t, filter);
  if (pair.bias < 0) return false;
  SideRowList from = own_position(filter);
  for (int k = 0; k < 3; ++k) {
    from[static_cast<std::size_t>(k)].d_side[pair.bias] = found.per_bias[k];
  }
  const double off_m = filter.side().mean[pair.bias] - found.bias_m;
  const Mat3 by_bias =
      found.bias_sigma_m * found.bias_sigma_m * found.per_bias * found.per_bias.transpose();
  return add_place(key, found.p_odom_m + off_m * found.per_bias, found.covariance_m2 - by_bias,
                   from, filter);
}

/// @param covariance_m2 of what the place errs by besides `from`
bool RangeStage::add_place(const PlaceKey& key, const Vec3& p_odom_m, const Mat3& covariance_m2,
                           const SideRowList& from, SideFilter& filter) {
  const SideStates::Vector mean = p_odom_m;
  const SideStates::Matrix covariance = covariance_m2;
  const int side = filter.add_side(mean, covariance, from);
  if (side < 0) return false;
  places_.emplace(key, Place{side, Vec3::Zero(), std::nullopt});
  return true;
}

}  // namespace rali::vehicle
