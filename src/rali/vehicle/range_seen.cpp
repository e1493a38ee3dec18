// Relative positions that vehicles at standstill report to each other.
#include <algorithm>

#include <Eigen/Geometry>

#include "rali/fleet/path/level.hpp"
#include "rali/ranging/path_fit.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using odometry::Moment;
using sensor::RangeSample;

/// Rotation of the peer's start in odom, as measured by hand.
Mat3 RangeStage::start_of(const PeerWatch& peer) const {
  return fleet::level_start(*first_pose_, up_odom_).R * peer.settings.prior->T_self_peer.R;
}

std::vector<SeenPeer> RangeStage::seen(const AugmentedFilter& filter,
                                       const SE3& T_odom_body) const {
  std::vector<SeenPeer> out;
  for (const auto& [key, place] : places_) {
    const auto& [peer, antenna] = key;
    out.push_back({peer, antenna,
                   filter.augmented().mean.segment<3>(place.state_index) - T_odom_body.p,
                   between(place, filter)});
  }
  return out;
}

/// Position of the peer's antenna by the relative position of this vehicle that the peer reports.
/// Its covariance is relative to the body, in odom axes.
std::optional<KnownLandmark> RangeStage::place_as_seen(const LandmarkKey& key,
                                                       const SE3& T_odom_body) const {
  const auto& [id, antenna] = key;
  const PeerWatch& peer = peers_.at(id);
  if (!peer.at_rest || !peer.pose || !peer.settings.prior || !first_pose_) return std::nullopt;
  const Mat3 R_odom_start = start_of(peer);
  for (const SeenPeer& me : peer.pose->seen) {
    if (me.vehicle != self_ || me.antenna >= settings_.antennas_body_m.size()) continue;
    const Vec3 lever = peer.pose->T_start_body.R * peer.settings.antennas_body_m[antenna];
    KnownLandmark place;
    place.p_odom_m = T_odom_body * settings_.antennas_body_m[me.antenna] +
                     R_odom_start * (lever - me.apart_start_m);
    const double yaw_rad = peer.settings.prior->sigma_rad;
    const Vec3 arm = yaw_rad * up_odom_.cross(R_odom_start * me.apart_start_m);
    place.covariance_m2 =
        R_odom_start * me.covariance_m2 * R_odom_start.transpose() + arm * arm.transpose();
    return place;
  }
  return std::nullopt;
}

/// At short range, neither the peer's reported path nor the range determines on which side it is.
/// But it came here by ranges to this vehicle, so it has a landmark of this vehicle relative to
/// itself.
///
/// Its report is no independent measurement of this vehicle's position, only of their distance. It
/// depends on the pair's bias, which this vehicle estimates too: the variance of that is added.
bool RangeStage::initialise_from_peer(const PairKey& key, const Moment& now,
                                      const RangeSample& sample, double sigma_m,
                                      AugmentedFilter& filter) {
  const LandmarkKey landmark_key{std::get<1>(key), std::get<2>(key)};
  if (!now.at_rest || lost_.contains(landmark_key)) return false;
  Pair& pair = pair_of(key);
  std::optional<KnownLandmark> place = place_as_seen(landmark_key, now.T_odom_body);
  if (!place || !agrees(pair, sample, now.v_odom_mps.norm())) return false;
  const Vec3 apart =
      place->p_odom_m - now.T_odom_body * settings_.antennas_body_m[std::get<0>(key)];
  const double apart_m = std::max(settings_.ranging.limits.near_m, apart.norm());
  const Vec3 e = apart / apart_m;
  const double bias_sigma_m = ranging::bias_sigma_m(settings_.ranging.bias, false);
  place->covariance_m2 += bias_sigma_m * bias_sigma_m * e * e.transpose();
  const ranging::FinderSettings& s = settings_.ranging.finder;
  // Ranges hardly observe the height of the peer, and its height is not needed.
  const Mat3 level = Mat3::Identity() - up_odom_ * up_odom_.transpose();
  const Mat3 level_m2 = level * place->covariance_m2 * level;
  if (level_m2.diagonal().maxCoeff() > s.sigma_max_m * s.sigma_max_m) return false;
  const double S_m2 = e.dot(place->covariance_m2 * e) + sigma_m * sigma_m;
  const double bias_m = pair.bias >= 0 ? filter.augmented().mean[pair.bias] : pair.bias_m;
  const double off_m = sample.range_m - bias_m - apart_m;
  if (off_m * off_m > s.report_sigmas * s.report_sigmas * S_m2) return false;
  if (!add_place(landmark_key, place->p_odom_m, place->covariance_m2, own_position(filter),
                 filter)) {
    return false;
  }
  pair.finder.reset();
  return true;
}

}  // namespace rali::vehicle
