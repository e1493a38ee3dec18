#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using odometry::AugmentedFilter;
using odometry::AugmentedMeasurement;
using odometry::AugmentedRowList;
using odometry::AugmentedStates;
using odometry::Moment;
using ranging::LandmarkMixture;

namespace {

/// The level direction of largest variance, unit.
Vec3 worst_level(const Mat3& covariance_m2, const Vec3& up) {
  const Mat3 level = Mat3::Identity() - up * up.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(Mat3(level * covariance_m2 * level));
  const Vec3 worst = level * solver.eigenvectors().col(2);
  return worst.normalized();
}

/// How far the peer is ahead along the passage.
double ahead_m(const Vec3& along_odom, const ranging::MixtureSight& sight) {
  return along_odom.dot(sight.p_odom_peer_m - sight.p_odom_antenna_m);
}

AugmentedMeasurement row_of(const AugmentedFilter& filter) {
  AugmentedMeasurement row;
  row.d_augmented = AugmentedStates::Vector::Zero(filter.augmented().size());
  return row;
}

}  // namespace

/// Where the LiDAR constrains the pose in every direction, ranges cannot spoil it. Along a
/// degenerate direction a landmark with a wrong lateral position would.
void RangeStage::enter_passage(Place& place, const Mat3& P_between_m2, const Moment& now,
                               AugmentedFilter& filter) {
  const ranging::MixtureSettings& s = settings_.ranging.mixture;
  if (place.passage || place.passed || !s.use) return;
  const std::optional<Vec3> axis = filter.degenerate_axis();
  if (!axis) return;
  const Vec3 across = worst_level(P_between_m2, up_odom_);
  constexpr double kRather = 0.7;  // cosine; more across than along
  if (across.dot(P_between_m2 * across) < s.uncertainty_m * s.uncertainty_m ||
      std::abs(across.dot(*axis)) > kRather) {
    return;
  }
  LandmarkMixture::Matrix none =
      LandmarkMixture::Matrix::Identity(LandmarkMixture::kBias, LandmarkMixture::kBias);
  place.passage.emplace(Passage{LandmarkMixture(s, across.cross(up_odom_), across, none),
                                {},
                                *axis,
                                now.t,
                                now.t,
                                std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity(),
                                std::nullopt});
  const AugmentedRowList rows = rows_of(place, filter);
  place.passage->mixture =
      LandmarkMixture(s, across.cross(up_odom_), across, filter.covariance(rows));
}

/// Derivatives of the mixture's quantities by the filter's state.
AugmentedRowList RangeStage::rows_of(const Place& place, const AugmentedFilter& filter) const {
  const Passage& passage = *place.passage;
  AugmentedRowList rows(LandmarkMixture::kBias, row_of(filter));
  rows[LandmarkMixture::kAlong].d_pose.tail<3>() = passage.axis_odom.transpose();
  rows[LandmarkMixture::kSpeed].d_velocity = passage.axis_odom.transpose();
  rows[LandmarkMixture::kPlace].d_augmented.segment<3>(place.state_index) =
      passage.mixture.along_odom();
  rows[LandmarkMixture::kAcross].d_augmented.segment<3>(place.state_index) =
      passage.mixture.across_odom();
  rows[LandmarkMixture::kClock].d_augmented[tau_] = 1.0;
  for (const PairKey& key : passage.pairs) {
    rows.push_back(row_of(filter));
    rows.back().d_augmented[pairs_.at(key).bias] = 1.0;
  }
  return rows;
}

void RangeStage::predict_in_passage(const PairKey& key, Place& place, const Moment& now,
                                    AugmentedFilter& filter, Prediction& prediction) {
  const ranging::MixtureSettings& s = settings_.ranging.mixture;
  Passage& passage = *place.passage;
  if (const std::optional<Vec3> axis = filter.degenerate_axis()) {
    passage.axis_odom = axis->dot(passage.axis_odom) < 0.0 ? Vec3(-*axis) : *axis;
    passage.t_degenerate = now.t;
  } else if ((now.t - passage.t_degenerate).s() > s.patience_s) {
    place.passage.reset();
    return;
  }
  const double dt_s = std::max(0.0, (now.t - passage.t).s());
  passage.t = std::max(passage.t, now.t);
  passage.mixture.move(dt_s, filter.covariance(rows_of(place, filter)));
  const auto known = std::find(passage.pairs.begin(), passage.pairs.end(), key);
  prediction.mixture_bias =
      LandmarkMixture::kBias + static_cast<int>(known - passage.pairs.begin());
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
  prediction.sight.tau_s = filter.augmented().mean[tau_];
  if (!passage.ahead_m) passage.ahead_m = ahead_m(passage.mixture.along_odom(), prediction.sight);
  const ranging::FinderSettings& f = settings_.ranging.finder;
  constexpr double kNearer = 0.9;
  if (prediction.predicted_m < kNearer * passage.reported_at_m) {
    passage.reported_at_m = prediction.predicted_m;
    const ranging::LateralOffset lateral = ranging::lateral_offset_in_passage(
        f,
        lateral_offset_by_walls({std::get<1>(key), std::get<2>(key)}, prediction.p_odom_antenna_m,
                                passage.axis_odom, filter),
        prediction.predicted_m);
    passage.mixture.stands_within(prediction.sight, lateral.mean_m, lateral.sigma_m);
  }
  const ranging::MixturePrediction p =
      passage.mixture.predict(prediction.sight, prediction.mixture_bias);
  prediction.passage = &passage;
  prediction.predicted_m = p.predicted_m + prediction.bias_m;
  prediction.variance_m2 = p.variance_m2;
  prediction.bent_sigma_m = 0.0;  // included in the variance of each slice
}

Vec3 RangeStage::update_in_passage(const LandmarkKey& key, const Prediction& prediction,
                                   double R_m2, AugmentedFilter& filter) {
  Place& place = places_.at(key);
  Passage& passage = *place.passage;
  LandmarkMixture& mixture = passage.mixture;
  const bool near = prediction.predicted_m * settings_.ranging.finder.passage_per_m < 1.0;
  mixture.update(prediction.sight, prediction.mixture_bias, prediction.measurement.residual, R_m2,
                 near);
  passage.nearest_m = std::min(passage.nearest_m, prediction.predicted_m);
  const bool far = prediction.predicted_m > passage.nearest_m + settings_.ranging.mixture.past_m;
  const bool turned = ahead_m(mixture.along_odom(), prediction.sight) * *passage.ahead_m < 0.0;
  // Ranges may have been missing near it: then the change from ahead to behind shows the passage.
  if (far && (near || turned)) {
    mixture.take_side();
    place.passed = true;
  }
  const LandmarkMixture::Matrix P = mixture.covariance();
  const Vec3 shift = filter.replace(rows_of(place, filter), mixture.mean(), P);
  mixture.recentre();
  const double known_m = settings_.ranging.mixture.known_m;
  if (place.passed ||
      (near && P(LandmarkMixture::kAcross, LandmarkMixture::kAcross) < known_m * known_m)) {
    place.passage.reset();
  }
  return shift;
}

}  // namespace rali::vehicle
