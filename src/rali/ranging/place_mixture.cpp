#include "rali/ranging/place_mixture.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "rali/base/assert.hpp"
#include "rali/geometry/regression.hpp"

namespace rali::ranging {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Nearer to an antenna there is no direction to it.
constexpr double kLeast_m = 0.05;

/// Of a variance: losing less than that is rounding. Of the position all else counts, however
/// little: a LiDAR that is nearly blind pulls a little at each sweep, and what is told with no end
/// and never believed would carry the pose off. Speed also loses by what it has to do with biases.
constexpr double kLearnedAlong = 1e-5;
constexpr double kLearnedSpeed = 0.02;

/// And gaining more than that from one range to the next is somebody's doing.
constexpr double kWidenedShare = 0.5;

/// Times what is known already: a range that tells more is told in parts.
constexpr double kMuch = 4.0;

/// In slices: wider gaps part the sides of the way.
constexpr double kApart = 2.0;

double gauss(double nu, double S) { return std::exp(-0.5 * nu * nu / S) / std::sqrt(S); }

}  // namespace

PlaceMixture::PlaceMixture(const MixtureSettings& settings, const Vec3& along_odom,
                           const Vec3& across_odom, const Matrix& covariance)
    : settings_(settings), along_(along_odom), across_(across_odom), last_(covariance) {
  RALI_ASSERT(covariance.rows() == kBias && covariance.cols() == kBias);
  const double sigma_m = std::sqrt(std::max(1e-6, covariance(kAcross, kAcross)));
  const int half = std::min(static_cast<int>(settings.reach_sigmas * sigma_m / settings.slice_m),
                            settings.slices_max / 2);
  const double spacing_m = half > 0 ? settings.reach_sigmas * sigma_m / half : sigma_m;
  // Slices as wide as they are apart, less what their spread already is: the sum is the Gaussian.
  const double width_m = std::min(spacing_m, sigma_m);
  const double spread_m2 = std::max(1e-6, sigma_m * sigma_m - width_m * width_m);
  // Given the place across, the rest follows by regression.
  const Vector gain = covariance.col(kAcross) / (sigma_m * sigma_m);
  for (int k = -half; k <= half; ++k) {
    Slice slice;
    const double across_m = k * spacing_m;
    slice.mean = gain * across_m;
    slice.covariance =
        covariance + (width_m * width_m - sigma_m * sigma_m) * gain * gain.transpose();
    slice.log_weight = -0.5 * across_m * across_m / spread_m2;
    slices_.push_back(slice);
  }
  normalise();
}

int PlaceMixture::add_bias(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const int index = size();
  if (index >= kMax) return -1;
  RALI_ASSERT(covariance.rows() == index + 1 && covariance.cols() == index + 1);
  // Given the rest, the bias is what the regression on it says, in every slice.
  const Matrix known = covariance.topLeftCorner(index, index);
  const Eigen::RowVectorXd cross = covariance.row(index).head(index);
  const Eigen::RowVectorXd gain = geometry::regression(cross, known);
  const double apart_m2 = std::max(0.0, covariance(index, index) - gain.dot(cross));
  const auto grow = [&](Matrix& m) {
    const Eigen::RowVectorXd hangs = gain * m;
    m.conservativeResize(index + 1, index + 1);
    m.row(index).head(index) = hangs;
    m.col(index).head(index) = hangs.transpose();
    m(index, index) = hangs.dot(gain) + apart_m2;
  };
  for (Slice& s : slices_) {
    s.mean.conservativeResize(index + 1);
    s.mean[index] = gain.dot(s.mean.head(index));
    grow(s.covariance);
  }
  grow(last_);
  return index;
}

void PlaceMixture::move(double dt_s, const Matrix& covariance_now) {
  Matrix F = Matrix::Identity(size(), size());
  F(kAlong, kSpeed) = dt_s;
  const Matrix moved = F * last_ * F.transpose();
  // What wanders does so each for itself.
  const Vector gained = (covariance_now - moved).diagonal().cwiseMax(0.0);
  Matrix Q = Matrix::Zero(size(), size());
  Q.diagonal() = gained;
  // The own way drifts by its acceleration only: a part of it given to the position at once would
  // wander off with the bias in the end. Unless somebody widened it.
  const bool widened = gained[kAlong] > kWidenedShare * moved(kAlong, kAlong);
  const double noise = gained[kSpeed];
  Q(kAlong, kAlong) = noise * dt_s * dt_s / 3.0 + (widened ? gained[kAlong] : 0.0);
  Q(kAlong, kSpeed) = Q(kSpeed, kAlong) = 0.5 * noise * dt_s;
  for (Slice& s : slices_) {
    s.mean = (F * s.mean).eval();
    s.covariance = (F * s.covariance * F.transpose() + Q).eval();
  }
  for (const int k : {kAlong, kSpeed}) {
    const double before = moved(k, k);
    const double after = std::max(1e-12, covariance_now(k, k));
    const double share = k == kAlong ? kLearnedAlong : kLearnedSpeed;
    if (after < (1.0 - share) * before) learn_zero(k, after * before / (before - after));
  }
  last_ = covariance_now;
}

/// The filter has learned this quantity: its value is the filter's, with so much information
/// gained.
void PlaceMixture::learn_zero(int index, double R) {
  for (Slice& s : slices_) {
    const Vector PH = s.covariance.col(index);
    const double S = PH[index] + R;
    s.mean -= (PH * (s.mean[index] / S)).eval();
    s.covariance -= (PH * PH.transpose() / S).eval();
  }
}

void PlaceMixture::stands_within(const MixtureSight& sight, double mean_m, double sigma_m) {
  const Vec3 aside = (along_.cross(across_)).cross(sight.axis_odom).normalized();
  for (Slice& s : slices_) {
    const Vec3 p = sight.p_odom_peer_m + s.mean[kPlace] * along_ + s.mean[kAcross] * across_;
    const double d = (aside.dot(p - sight.p_odom_antenna_m) - mean_m) / sigma_m;
    s.log_passage = -0.5 * d * d;
  }
  normalise();
}

PlaceMixture::Expected PlaceMixture::expected(const Slice& s, const MixtureSight& sight,
                                              int bias) const {
  Expected out;
  const Vec3 h = sight.p_odom_antenna_m + s.mean[kAlong] * sight.axis_odom - sight.p_odom_peer_m -
                 s.mean[kPlace] * along_ - s.mean[kAcross] * across_;
  const double rho = std::max(kLeast_m, h.norm());
  const Vec3 u = h / rho;
  const double rate_mps = u.dot(sight.v_odom_antenna_mps + s.mean[kSpeed] * sight.axis_odom);
  out.row = Vector::Zero(size());
  out.row[kAlong] = u.dot(sight.axis_odom);
  out.row[kPlace] = -u.dot(along_);
  out.row[kAcross] = -u.dot(across_);
  out.row[kClock] = rate_mps;
  out.row[bias] = 1.0;
  // Second order: what the distance bends by within the slice.
  Eigen::Matrix<double, 3, 3> J;
  J << sight.axis_odom, -along_, -across_;
  constexpr int kPlaces[] = {kAlong, kPlace, kAcross};
  Mat3 P;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) P(i, j) = s.covariance(kPlaces[i], kPlaces[j]);
  }
  const Mat3 aside = Mat3::Identity() - u * u.transpose();
  const Mat3 M = aside * (J * P * J.transpose()) * aside / rho;
  out.bend_m2 = 0.5 * (M * M).trace();
  out.range_m = rho + 0.5 * M.trace() + s.mean[bias] + (sight.tau_s + s.mean[kClock]) * rate_mps;
  out.variance_m2 = out.row.dot(s.covariance * out.row) + out.bend_m2;
  return out;
}

MixturePrediction PlaceMixture::predict(const MixtureSight& sight, int bias) const {
  MixturePrediction out;
  double square = 0.0;
  for (const Slice& s : slices_) {
    const Expected e = expected(s, sight, bias);
    out.predicted_m += s.weight * e.range_m;
    square += s.weight * (e.range_m * e.range_m + e.variance_m2);
  }
  out.variance_m2 = std::max(0.0, square - out.predicted_m * out.predicted_m);
  return out;
}

void PlaceMixture::update(const MixtureSight& sight, int bias, double residual_m, double R_m2,
                          bool learns_across) {
  const double measured_m = predict(sight, bias).predicted_m + residual_m;
  const double wild_m2 = settings_.wild_sigma_m * settings_.wild_sigma_m;
  for (Slice& s : slices_) {
    const Expected e = expected(s, sight, bias);
    const double nu = measured_m - e.range_m;
    const double S = e.variance_m2 + R_m2;
    learn(s, sight, bias, measured_m, R_m2, learns_across);
    if (!learns_across) continue;
    const double likelihood =
        (1.0 - settings_.wild_share) * gauss(nu, S) + settings_.wild_share * gauss(nu, S + wild_m2);
    s.log_weight += std::log(std::max(1e-300, likelihood));
  }
  normalise();
}

/// A range that says much more than was known moves the slice far, and there the distance bends
/// otherwise: it is told in parts, each at the place to which the last one led. Where nothing bends
/// the parts are the whole.
void PlaceMixture::learn(Slice& s, const MixtureSight& sight, int bias, double measured_m,
                         double R_m2, bool learns_across) {
  double told = 0.0;
  for (;;) {
    const Expected e = expected(s, sight, bias);
    const double untold = 1.0 / (R_m2 + e.bend_m2) - told;
    if (untold <= 0.0) return;
    const double known = 1.0 / std::max(1e-9, e.variance_m2 - e.bend_m2);
    const double part = untold < kMuch * known ? untold : known;
    told += part;
    const Vector PH = s.covariance * e.row;
    const double S = e.row.dot(PH) + 1.0 / part;
    Vector moved = PH;
    if (!learns_across) moved[kAcross] = 0.0;
    s.mean += moved * ((measured_m - e.range_m) / S);
    s.covariance -=
        ((moved * PH.transpose() + PH * moved.transpose() - moved * moved.transpose()) / S).eval();
    if (part == untold) return;
  }
}

void PlaceMixture::normalise() {
  double most = -1e300;
  for (const Slice& s : slices_) most = std::max(most, s.log_weight + s.log_passage);
  double sum = 0.0;
  for (Slice& s : slices_) {
    s.weight = std::exp(s.log_weight + s.log_passage - most);
    sum += s.weight;
  }
  for (Slice& s : slices_) {
    s.weight /= sum;
    s.log_weight -= most;
  }
  const double least = settings_.weight_min / static_cast<double>(slices_.size());
  std::erase_if(slices_, [least](const Slice& s) { return s.weight < least; });
  sum = 0.0;
  for (const Slice& s : slices_) sum += s.weight;
  for (Slice& s : slices_) s.weight /= sum;
}

PlaceMixture::Vector PlaceMixture::mean() const {
  Vector out = Vector::Zero(size());
  for (const Slice& s : slices_) out += s.weight * s.mean;
  return out;
}

PlaceMixture::Matrix PlaceMixture::covariance() const {
  const Vector middle = mean();
  Matrix out = Matrix::Zero(size(), size());
  for (const Slice& s : slices_) {
    const Vector d = s.mean - middle;
    out += s.weight * (s.covariance + d * d.transpose());
  }
  return out;
}

double PlaceMixture::likeliest_across_m() const {
  const auto best =
      std::max_element(slices_.begin(), slices_.end(),
                       [](const Slice& a, const Slice& b) { return a.weight < b.weight; });
  return best->mean[kAcross];
}

void PlaceMixture::take_side() {
  // Slices that touch are one side: between the sides there is none left, by the nearest ranges.
  const double best_m = likeliest_across_m();
  std::sort(slices_.begin(), slices_.end(),
            [](const Slice& a, const Slice& b) { return a.mean[kAcross] < b.mean[kAcross]; });
  const double apart_m = kApart * settings_.slice_m;
  const auto best = std::find_if(slices_.begin(), slices_.end(),
                                 [best_m](const Slice& s) { return s.mean[kAcross] >= best_m; });
  auto first = best;
  while (first != slices_.begin() &&
         first->mean[kAcross] - std::prev(first)->mean[kAcross] < apart_m) {
    --first;
  }
  auto last = std::next(best);
  while (last != slices_.end() && last->mean[kAcross] - std::prev(last)->mean[kAcross] < apart_m) {
    ++last;
  }
  double doubt_m2 = 0.0;
  for (auto s = slices_.begin(); s != slices_.end(); ++s) {
    if (s >= first && s < last) continue;
    const double off_m = s->mean[kAcross] - best_m;
    doubt_m2 += s->weight * off_m * off_m;
  }
  slices_ = std::vector<Slice>(first, last);
  for (Slice& s : slices_) s.covariance(kAcross, kAcross) += doubt_m2;
  normalise();
}

void PlaceMixture::recentre() {
  last_ = covariance();
  const Vector middle = mean();
  for (Slice& s : slices_) s.mean -= middle;
}

}  // namespace rali::ranging
