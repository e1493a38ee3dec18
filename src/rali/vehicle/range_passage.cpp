#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::Moment;
using odometry::SideFilter;
using odometry::SideMeasurement;
using odometry::SideRowList;
using odometry::SideStates;
using ranging::PlaceMixture;

namespace {

/// The level direction in which a place is known worst, unit.
Vec3 worst_level(const Mat3& covariance_m2, const Vec3& up) {
  const Mat3 level = Mat3::Identity() - up * up.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(level * covariance_m2 * level);
  const Vec3 worst = level * solver.eigenvectors().col(2);
  return worst.normalized();
}

/// How far the peer is ahead along the passage.
double ahead_m(const Vec3& along_odom, const ranging::MixtureSight& sight) {
  return along_odom.dot(sight.p_odom_peer_m - sight.p_odom_antenna_m);
}

SideMeasurement row_of(const SideFilter& filter) {
  SideMeasurement row;
  row.d_side = SideStates::Vector::Zero(filter.side().size());
  return row;
}

}  // namespace

/// Where the LiDAR holds the pose in every direction ranges have nothing to ruin; where it is blind
/// along one, a wrong place across would.
void RangeStage::enter_passage(Place& place, const Mat3& P_between_m2, const Moment& now,
                               SideFilter& filter) {
  const ranging::MixtureSettings& s = settings_.ranging.mixture;
  if (place.passage || place.passed || !s.use) return;
  const std::optional<Vec3> axis = filter.blind_axis();
  if (!axis) return;
  const Vec3 across = worst_level(P_between_m2, up_odom_);
  constexpr double kRather = 0.7;  // across than along
  if (across.dot(P_between_m2 * across) < s.doubt_m * s.doubt_m ||
      std::abs(across.dot(*axis)) > kRather) {
    return;
  }
  PlaceMixture::Matrix none =
      PlaceMixture::Matrix::Identity(PlaceMixture::kBias, PlaceMixture::kBias);
  place.passage.emplace(Passage{PlaceMixture(s, across.cross(up_odom_), across, none),
                                {},
                                *axis,
                                now.t,
                                now.t,
                                std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity(),
                                std::nullopt});
  const SideRowList rows = rows_of(place, filter);
  place.passage->mixture = PlaceMixture(s, across.cross(up_odom_), across, filter.covariance(rows));
}

/// The mixture's quantities as functions of the filter's state.
SideRowList RangeStage::rows_of(const Place& place, const SideFilter& filter) const {
  const Passage& passage = *place.passage;
  SideRowList rows(PlaceMixture::kBias, row_of(filter));
  rows[PlaceMixture::kAlong].d_pose.tail<3>() = passage.axis_odom.transpose();
  rows[PlaceMixture::kSpeed].d_velocity = passage.axis_odom.transpose();
  rows[PlaceMixture::kPlace].d_side.segment<3>(place.side) = passage.mixture.along_odom();
  rows[PlaceMixture::kAcross].d_side.segment<3>(place.side) = passage.mixture.across_odom();
  rows[PlaceMixture::kClock].d_side[tau_] = 1.0;
  for (const PairKey& key : passage.pairs) {
    rows.push_back(row_of(filter));
    rows.back().d_side[pairs_.at(key).bias] = 1.0;
  }
  return rows;
}

void RangeStage::predict_in_passage(const PairKey& key, Place& place, const Moment& now,
                                    SideFilter& filter, Prediction& prediction) {
  const ranging::MixtureSettings& s = settings_.ranging.mixture;
  Passage& passage = *place.passage;
  if (const std::optional<Vec3> axis = filter.blind_axis()) {
    passage.axis_odom = axis->dot(passage.axis_odom) < 0.0 ? Vec3(-*axis) : *axis;
    passage.t_blind = now.t;
  } else if ((now.t - passage.t_blind).s() > s.patience_s) {
    place.passage.reset();
    return;
  }
  const double dt_s = std::max(0.0, (now.t - passage.t).s());
  passage.t = std::max(passage.t, now.t);
  passage.mixture.move(dt_s, filter.covariance(rows_of(place, filter)));
  const auto known = std::find(passage.pairs.begin(), passage.pairs.end(), key);
  prediction.mixture_bias = PlaceMixture::kBias + static_cast<int>(known - passage.pairs.begin());
  if (known == passage.pairs.end()) {
    passage.pairs.push_back(key);
    if (passage.mixture.add_bias(filter.covariance(rows_of(place, filter))) < 0) {
      passage.pairs.pop_back();
      return;
    }
  }
  const Vec3 lever = now.T_odom_body.R * settings_.antennas_body_m[std::get<0>(key)];
  prediction.sight.p_odom_antenna_m = prediction.p_odom_antenna_m;
  prediction.sight.v_odom_antenna_mps =
      now.v_odom_mps + (now.T_odom_body.R * now.w_body_radps).cross(lever);
  prediction.sight.p_odom_peer_m = prediction.p_odom_peer_m;
  prediction.sight.axis_odom = passage.axis_odom;
  prediction.sight.tau_s = filter.side().mean[tau_];
  if (!passage.ahead_m) passage.ahead_m = ahead_m(passage.mixture.along_odom(), prediction.sight);
  const ranging::FinderSettings& f = settings_.ranging.finder;
  constexpr double kNearer = 0.9;
  if (prediction.predicted_m < kNearer * passage.said_at_m) {
    passage.said_at_m = prediction.predicted_m;
    const ranging::Aside aside = ranging::aside_in_passage(
        f,
        aside_by_walls({std::get<1>(key), std::get<2>(key)}, prediction.p_odom_antenna_m,
                       passage.axis_odom, filter),
        prediction.predicted_m);
    passage.mixture.stands_within(prediction.sight, aside.mean_m, aside.sigma_m);
  }
  const ranging::MixturePrediction p =
      passage.mixture.predict(prediction.sight, prediction.mixture_bias);
  prediction.passage = &passage;
  prediction.predicted_m = p.predicted_m + prediction.bias_m;
  prediction.variance_m2 = p.variance_m2;
  prediction.bent_sigma_m = 0.0;  // each slice has its own
}

Vec3 RangeStage::update_in_passage(const PlaceKey& key, const Prediction& prediction, double R_m2,
                                   SideFilter& filter) {
  Place& place = places_.at(key);
  Passage& passage = *place.passage;
  PlaceMixture& mixture = passage.mixture;
  const bool near = prediction.predicted_m * settings_.ranging.finder.passage_per_m < 1.0;
  mixture.update(prediction.sight, prediction.mixture_bias, prediction.measurement.residual, R_m2,
                 near);
  passage.nearest_m = std::min(passage.nearest_m, prediction.predicted_m);
  const bool far = prediction.predicted_m > passage.nearest_m + settings_.ranging.mixture.past_m;
  const bool turned = ahead_m(mixture.along_odom(), prediction.sight) * *passage.ahead_m < 0.0;
  // The ranges may have been silent while it was near: then the side is told by where it is now.
  if (far && (near || turned)) {
    mixture.take_side();
    place.passed = true;
  }
  const PlaceMixture::Matrix P = mixture.covariance();
  const Vec3 shift = filter.replace(rows_of(place, filter), mixture.mean(), P);
  mixture.recentre();
  const double known_m = settings_.ranging.mixture.known_m;
  if (place.passed ||
      (near && P(PlaceMixture::kAcross, PlaceMixture::kAcross) < known_m * known_m)) {
    place.passage.reset();
  }
  return shift;
}

}  // namespace rali::vehicle
