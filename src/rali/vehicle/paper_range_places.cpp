// The part of PaperRangeStage that locates peers and calibrates pairs of radios.
#include <algorithm>
#include <cmath>

#include "rali/fleet/path/level.hpp"
#include "rali/ranging/path_fit.hpp"
#include "rali/vehicle/paper_range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using odometry::ScanResult;

namespace {

const Vec3 kUpOdom = Vec3::UnitZ();

/// Prior of a pair whose peer was measured by hand at the start.
ranging::PairPrior prior_of(const PeerWatch& peer, const SE3& T_odom_first,
                            const ranging::RangingSettings& settings) {
  const PeerPrior& given = *peer.settings.prior;
  ranging::PairPrior prior;
  prior.origin_m = fleet::level_start(T_odom_first, kUpOdom) * given.T_self_peer.p;
  prior.sigma_m = given.sigma_m;
  prior.sigma_rad = given.sigma_rad;
  prior.constant_sigma_m = ranging::bias_sigma_m(settings.bias, peer.settings.bias_m.has_value());
  prior.range_sigma_m = settings.paper.range_sigma_m;
  return prior;
}

}  // namespace

/// Position of the peer, from the start pose measured by hand, its calibration by ranges, and the
/// path reported by the peer since.
void PaperRangeStage::fix_landmark(const PairKey& key, Pair& pair) {
  if (pair.p_odom_peer_m || !first_pose_) return;
  const PeerWatch& peer = peers_.at(std::get<1>(key));
  const std::optional<KnownLandmark> place = place_of(peer, peers_end(key), *first_pose_, kUpOdom);
  if (!place) return;
  pair.p_odom_peer_m = place->p_odom_m;
  pair.place_covariance_m2 = place->covariance_m2;
  if (literal_) return;
  if (!pair.calibration) pair.calibration.emplace(prior_of(peer, *first_pose_, settings_.ranging));
  // Both paths may have drifted since the start.
  Mat3 drift_m2 = covariance_m2_;
  if (peer.moved) {
    const Mat3 R = fleet::level_start(*first_pose_, kUpOdom).R * peer.settings.prior->T_self_peer.R;
    drift_m2 += R * peer.pose->position_covariance_m2 * R.transpose();
  }
  pair.calibration->start_stay(place->p_odom_m, drift_m2);
  pair.p_odom_peer_m = pair.calibration->place_m();
}

/// Calibrates by a smoothed range where the LiDAR constrains the position, or at standstill: there
/// it measures the peer's position and the pair's constant.
void PaperRangeStage::calibrate(const PairKey& key, Pair& pair, const ScanResult& result,
                                const SE3& T_end) {
  if (!pair.calibration || !pair.calibration->in_stay() || !pair.newest) return;
  if (result.state != odometry::TrackState::kGood) return;
  const ranging::SmoothedRange& smoothed = *pair.newest;
  const bool fresh = smoothed.t > t_last_ && smoothed.samples >= paper_.smoother_samples_min;
  const bool clear =
      !pair.t_unclear || seconds_between(*pair.t_unclear, smoothed.t) > paper_.smoother_s;
  if (!fresh || !clear) return;
  if (!result.at_rest && degree_of(result).degenerate) return;
  const Vec3 p_m = pose_at(smoothed.t, result.t, T_end) * own_end(key);
  if (pair.calibration->add(p_m, smoothed.range_m)) {
    pair.p_odom_peer_m = pair.calibration->place_m();
  }
}

/// With the sigma of a single range: smoothed ones share their errors.
odometry::KnownAlong PaperRangeStage::known_along(const Candidate& candidate, const Vec3& e3_odom,
                                                  const Vec3& shift_odom_m) const {
  constexpr double kAlongMin = 0.1;
  const double along = std::max(candidate.along, kAlongMin);
  odometry::KnownAlong known;
  known.e_odom = e3_odom;
  known.shift_m = shift_odom_m.dot(e3_odom);
  known.sigma_m = paper_.range_sigma_m / along;
  const auto& calibration = candidate.pair->calibration;
  const Mat3& P = candidate.pair->place_covariance_m2;
  known.place_sigma_m = calibration
                            ? std::sqrt(calibration->variance_m2(candidate.p_odom_m)) / along
                            : std::sqrt(std::max(0.0, e3_odom.dot(P * e3_odom)));
  return known;
}

}  // namespace rali::vehicle
