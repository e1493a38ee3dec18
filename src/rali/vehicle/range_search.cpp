#include <cmath>

#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using odometry::AugmentedMeasurement;
using odometry::AugmentedRowList;
using odometry::AugmentedStates;
using odometry::Moment;
using sensor::RangeSample;

/// Derivatives of the own position by the filter's state.
AugmentedRowList RangeStage::own_position(const AugmentedFilter& filter) {
  AugmentedRowList rows(3);
  for (int k = 0; k < 3; ++k) {
    AugmentedMeasurement& row = rows[static_cast<std::size_t>(k)];
    row.d_augmented = AugmentedStates::Vector::Zero(filter.augmented().size());
    row.d_pose[3 + k] = 1.0;
  }
  return rows;
}

/// Covariance of the vector between vehicle and landmark: a landmark initialised from the own
/// position shares its error.
Mat3 RangeStage::between(const Place& place, const AugmentedFilter& filter) const {
  AugmentedRowList rows = own_position(filter);
  for (int k = 0; k < 3; ++k)
    rows[static_cast<std::size_t>(k)].d_augmented[place.state_index + k] = -1.0;
  return filter.covariance(rows);
}

/// Initialises from the start pose measured by hand and the path reported by the peer since.
bool RangeStage::place_from_prior(const LandmarkKey& key, AugmentedFilter& filter) {
  const PeerWatch& peer = peers_.at(std::get<0>(key));
  // Along a degenerate direction the peer is located by ranges only, some of them to this vehicle.
  const bool by_ranges = peer.moved && filter.degenerate_axis();
  if (lost_.contains(key) || !first_pose_ || by_ranges) return false;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<1>(key)];
  const std::optional<KnownLandmark> place = place_of(peer, lever, *first_pose_, up_odom_);
  return place && add_place(key, place->p_odom_m, place->covariance_m2, {}, filter);
}

/// In a degenerate direction, a peer that has moved is located by ranges to this vehicle, among
/// others: its report is not independent. Vehicles that treated it as independent stated
/// 0.2 m where they were 1.6 m off after 100 m. So the report decides only whether the peer is
/// ahead or behind, if it leaves no ambiguity. The distance comes from the range, as a measurement,
/// once the landmark is roughly initialised. Across that direction each is located by its own
/// LiDAR.
bool RangeStage::initialise_by_lateral_offset(const PairKey& key, const Moment& now,
                                              const RangeSample& sample, double sigma_m,
                                              AugmentedFilter& filter) {
  const LandmarkKey landmark_key{std::get<1>(key), std::get<2>(key)};
  const PeerWatch& peer = peers_.at(std::get<1>(key));
  const bool by_ranges = peer.moved && filter.degenerate_axis();
  if (!by_ranges || !first_pose_ || lost_.contains(landmark_key)) return false;
  const Vec3 lever = peer.settings.antennas_body_m[std::get<2>(key)];
  const std::optional<KnownLandmark> reported = place_of(peer, lever, *first_pose_, up_odom_);
  Pair& pair = pair_of(key);
  if (!reported || !agrees(pair, sample, now.v_odom_mps.norm())) return false;
  const ranging::FinderSample seen = finder_sample(key, now, sample, sigma_m, filter);
  const AugmentedRowList own = own_position(filter);
  const Vec3 apart = reported->p_odom_m - seen.p_odom_antenna_m;
  const Mat3 apart_m2 = reported->covariance_m2 + filter.covariance(own);
  const auto reported_along = [&](const Vec3& d) {
    return Reported{d.dot(apart), d.dot(apart_m2 * d)};
  };
  const Vec3& axis = *seen.passage_odom;
  const Reported ahead = reported_along(axis);
  const auto lateral = lateral_as_reported(
      reported_along(up_odom_.cross(axis).normalized()),
      ranging::lateral_offset_in_passage(settings_.ranging.finder, seen.by_walls, sample.range_m));
  if (!lateral) return false;
  const double bias_m = pair.bias >= 0 ? filter.augmented().mean[pair.bias] : pair.bias_m;
  ranging::FoundAnchor place =
      ranging::place_along_passage(settings_.ranging.finder, seen, height_of(key), bias_m, up_odom_,
                                   ahead.value_m > 0.0, *lateral);
  const Reported there{axis.dot(place.p_odom_m - seen.p_odom_antenna_m),
                       axis.dot(place.covariance_m2 * axis)};
  if (!shows_side(ahead, there)) return false;
  const double roughly_m = settings_.ranging.finder.roughly_m;
  place.covariance_m2 += roughly_m * roughly_m * axis * axis.transpose();
  if (!add_place(landmark_key, place.p_odom_m, place.covariance_m2, own, filter)) return false;
  places_.at(landmark_key).lateral_sigma_m = lateral_sigma_m(seen);
  pair.finder.reset();
  return true;
}

/// Combines the bound by the passage and the report of the peer; nothing if they contradict each
/// other.
std::optional<ranging::LateralOffset> RangeStage::lateral_as_reported(
    const Reported& reported, const ranging::LateralOffset& passage) const {
  const double report_sigmas = settings_.ranging.finder.report_sigmas;
  const double passage_m2 = passage.sigma_m * passage.sigma_m;
  const double both_m2 = passage_m2 + reported.variance_m2;
  const double off_m = reported.value_m - passage.mean_m;
  if (off_m * off_m > report_sigmas * report_sigmas * both_m2) return std::nullopt;
  const double fraction = passage_m2 / both_m2;
  return ranging::LateralOffset{passage.mean_m + fraction * off_m,
                                std::sqrt(fraction * reported.variance_m2)};
}

/// Whether the range agrees with the last one: an outlier must not initialise a landmark.
bool RangeStage::agrees(const Pair& pair, const RangeSample& sample, double speed_mps) const {
  if (!pair.received) return false;
  const double dt_s = (sample.t - pair.received->first).s();
  const double sigma_m =
      ranging::sigma_of(sample.range_m, settings_.ranging.limits, sample.sigma_m);
  return dt_s >= 0.0 && dt_s < settings_.ranging.place_silent_s &&
         std::abs(sample.range_m - pair.received->second) <
             settings_.ranging.sanity.jump_sigmas * sigma_m + speed_mps * dt_s;
}

/// @param there distance ahead by the range, on the reported side
bool RangeStage::shows_side(const Reported& reported, const Reported& there) const {
  const double S = reported.variance_m2 + there.variance_m2;
  const double off_m = reported.value_m - there.value_m;
  const double off_other_m = reported.value_m + there.value_m;
  // At short range the passage is as wide as the peer is far: the range leaves the side open.
  const double bent_max_m = settings_.ranging.limits.bent_max_m;
  const double report_sigmas = settings_.ranging.finder.report_sigmas;
  return there.variance_m2 < bent_max_m * bent_max_m &&
         off_m * off_m < report_sigmas * report_sigmas * S &&
         (off_other_m * off_other_m - off_m * off_m) / S > settings_.ranging.finder.rival_chi2;
}

ranging::FinderSample RangeStage::finder_sample(const PairKey& key, const Moment& now,
                                                const RangeSample& sample, double sigma_m,
                                                const AugmentedFilter& filter) const {
  ranging::FinderSample s;
  s.t = sample.t;
  s.p_odom_antenna_m = now.T_odom_body * settings_.antennas_body_m[std::get<0>(key)];
  s.covariance_m2 = filter.position_covariance();
  s.passage_odom = filter.degenerate_axis();
  if (s.passage_odom) {
    s.by_walls = lateral_offset_by_walls({std::get<1>(key), std::get<2>(key)}, s.p_odom_antenna_m,
                                         *s.passage_odom, filter);
  }
  s.range_m = sample.range_m;
  s.sigma_m = sigma_m;
  return s;
}

/// Height of the other antenna above the own one if both vehicles are level.
double RangeStage::height_of(const PairKey& key) const {
  const auto& [own, peer, antenna] = key;
  return peers_.at(peer).settings.antennas_body_m[antenna].z() - settings_.antennas_body_m[own].z();
}

/// Sigma of the lateral offset with which the landmark was initialised.
double RangeStage::lateral_sigma_m(const ranging::FinderSample& seen) const {
  return ranging::lateral_offset_in_passage(settings_.ranging.finder, seen.by_walls, seen.range_m)
      .sigma_m;
}

/// Gathers ranges until they determine the position of the other antenna.
void RangeStage::initialise_landmark(const PairKey& key, const Moment& now,
                                     const RangeSample& sample, double sigma_m,
                                     AugmentedFilter& filter) {
  Pair& pair = pair_of(key);
  const LandmarkKey landmark_key{std::get<1>(key), std::get<2>(key)};
  // Ranges soon after it share its error: the thinning counts it although it only locates the peer.
  static_cast<void>(pair.thinning.inflation(sample.t, sigma_m, now.at_rest));
  const ranging::FinderSample seen = finder_sample(key, now, sample, sigma_m, filter);
  const auto found = pair.finder.add(seen, height_of(key), up_odom_);
  if (!found) return;
  if (!add_found(landmark_key, *found, pair, now.t, filter)) return;
  places_.at(landmark_key).lateral_sigma_m = lateral_sigma_m(seen);
  pair.finder.reset();
}

/// The landmark shares the errors of the own position and of the pair's bias from which it was
/// initialised. Without the correlation with the bias, each new landmark would halve the
/// uncertainty of the bias, and with it that of the path.
bool RangeStage::add_found(const LandmarkKey& key, const ranging::FoundAnchor& found, Pair& pair,
                           Time t, AugmentedFilter& filter) {
  add_pair_states(pair, t, filter);
  if (pair.bias < 0) return false;
  AugmentedRowList from = own_position(filter);
  for (int k = 0; k < 3; ++k) {
    from[static_cast<std::size_t>(k)].d_augmented[pair.bias] = found.per_bias[k];
  }
  const double off_m = filter.augmented().mean[pair.bias] - found.bias_m;
  const Mat3 by_bias =
      found.bias_sigma_m * found.bias_sigma_m * found.per_bias * found.per_bias.transpose();
  return add_place(key, found.p_odom_m + off_m * found.per_bias, found.covariance_m2 - by_bias,
                   from, filter);
}

/// @param covariance_m2 of the landmark's error that does not come from `from`
bool RangeStage::add_place(const LandmarkKey& key, const Vec3& p_odom_m, const Mat3& covariance_m2,
                           const AugmentedRowList& from, AugmentedFilter& filter) {
  const AugmentedStates::Vector mean = p_odom_m;
  const AugmentedStates::Matrix covariance = covariance_m2;
  const int state_index = filter.add_states(mean, covariance, from);
  if (state_index < 0) return false;
  places_.emplace(key, Place{state_index, Vec3::Zero(), std::nullopt});
  return true;
}

}  // namespace rali::vehicle
