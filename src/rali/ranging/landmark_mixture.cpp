#include "rali/ranging/landmark_mixture.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "rali/base/assert.hpp"
#include "rali/geometry/regression.hpp"

namespace rali::ranging {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Nearer to an antenna the direction to it is undefined.
constexpr double kMin_m = 0.05;

/// Smaller relative losses of variance are rounding. Of the position all others count, however
/// small: a nearly degenerate LiDAR adds a little information with each scan, and ignoring it
/// without end would let the pose drift off. Speed also loses variance by its correlation with
/// biases.
constexpr double kLearnedAlong = 1e-5;
constexpr double kLearnedSpeed = 0.02;

/// A larger relative gain from one range to the next means that the covariance was widened.
constexpr double kWidenedFraction = 0.5;

/// Times the information of the prior: a range with more is applied in parts.
constexpr double kMuch = 4.0;

/// In slices: wider gaps separate the two sides of the path.
constexpr double kApart = 2.0;

double gauss(double nu, double S) { return std::exp(-0.5 * nu * nu / S) / std::sqrt(S); }

}  // namespace

LandmarkMixture::LandmarkMixture(const MixtureSettings& settings, const Vec3& along_odom,
                                 const Vec3& across_odom, const Matrix& covariance)
    : settings_(settings), along_(along_odom), across_(across_odom), last_(covariance) {
  RALI_ASSERT(covariance.rows() == kBias && covariance.cols() == kBias);
  const double sigma_m = std::sqrt(std::max(1e-6, covariance(kAcross, kAcross)));
  const int half = std::min(static_cast<int>(settings.reach_sigmas * sigma_m / settings.slice_m),
                            settings.slices_max / 2);
  const double spacing_m = half > 0 ? settings.reach_sigmas * sigma_m / half : sigma_m;
  // Slices as wide as their spacing; their weights spread less by that, so the sum is the Gaussian.
  const double width_m = std::min(spacing_m, sigma_m);
  const double spread_m2 = std::max(1e-6, sigma_m * sigma_m - width_m * width_m);
  // Given the lateral position, the rest follows by regression.
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

int LandmarkMixture::add_bias(const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const int index = size();
  if (index >= kMax) return -1;
  RALI_ASSERT(covariance.rows() == index + 1 && covariance.cols() == index + 1);
  // Given the rest, the bias follows by regression on it, in every slice.
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

void LandmarkMixture::move(double dt_s, const Matrix& covariance_now) {
  Matrix F = Matrix::Identity(size(), size());
  F(kAlong, kSpeed) = dt_s;
  const Matrix moved = F * last_ * F.transpose();
  // Process noises are independent of each other.
  const Vector gained = (covariance_now - moved).diagonal().cwiseMax(0.0);
  Matrix Q = Matrix::Zero(size(), size());
  Q.diagonal() = gained;
  // The own path drifts by its acceleration only: noise of the position itself would in the end
  // drift off together with the bias. The exception is a widened covariance.
  const bool widened = gained[kAlong] > kWidenedFraction * moved(kAlong, kAlong);
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
    const double fraction = k == kAlong ? kLearnedAlong : kLearnedSpeed;
    if (after < (1.0 - fraction) * before) learn_zero(k, after * before / (before - after));
  }
  last_ = covariance_now;
}

/// The filter has measured this quantity: each slice is updated to the filter's value, with the
/// information gained.
void LandmarkMixture::learn_zero(int index, double R) {
  for (Slice& s : slices_) {
    const Vector PH = s.covariance.col(index);
    const double S = PH[index] + R;
    s.mean -= (PH * (s.mean[index] / S)).eval();
    s.covariance -= (PH * PH.transpose() / S).eval();
  }
}

void LandmarkMixture::stands_within(const MixtureSight& sight, double mean_m, double sigma_m) {
  const Vec3 lateral = (along_.cross(across_)).cross(sight.axis_odom).normalized();
  for (Slice& s : slices_) {
    const Vec3 p = sight.p_odom_peer_m + s.mean[kPlace] * along_ + s.mean[kAcross] * across_;
    const double d = (lateral.dot(p - sight.p_odom_antenna_m) - mean_m) / sigma_m;
    s.log_passage = -0.5 * d * d;
  }
  normalise();
}

LandmarkMixture::Expected LandmarkMixture::expected(const Slice& s, const MixtureSight& sight,
                                                    int bias) const {
  Expected out;
  const Vec3 h = sight.p_odom_antenna_m + s.mean[kAlong] * sight.axis_odom - sight.p_odom_peer_m -
                 s.mean[kPlace] * along_ - s.mean[kAcross] * across_;
  const double rho = std::max(kMin_m, h.norm());
  const Vec3 u = h / rho;
  const double rate_mps = u.dot(sight.v_odom_antenna_mps + s.mean[kSpeed] * sight.axis_odom);
  out.row = Vector::Zero(size());
  out.row[kAlong] = u.dot(sight.axis_odom);
  out.row[kPlace] = -u.dot(along_);
  out.row[kAcross] = -u.dot(across_);
  out.row[kClock] = rate_mps;
  out.row[bias] = 1.0;
  // Second-order term: curvature of the distance within the slice.
  Eigen::Matrix<double, 3, 3> J;
  J << sight.axis_odom, -along_, -across_;
  constexpr int kPlaces[] = {kAlong, kPlace, kAcross};
  Mat3 P;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) P(i, j) = s.covariance(kPlaces[i], kPlaces[j]);
  }
  const Mat3 lateral = Mat3::Identity() - u * u.transpose();
  const Mat3 M = lateral * (J * P * J.transpose()) * lateral / rho;
  out.bend_m2 = 0.5 * (M * M).trace();
  out.range_m = rho + 0.5 * M.trace() + s.mean[bias] + (sight.tau_s + s.mean[kClock]) * rate_mps;
  out.variance_m2 = out.row.dot(s.covariance * out.row) + out.bend_m2;
  return out;
}

MixturePrediction LandmarkMixture::predict(const MixtureSight& sight, int bias) const {
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

void LandmarkMixture::update(const MixtureSight& sight, int bias, double residual_m, double R_m2,
                             bool learns_across) {
  const double measured_m = predict(sight, bias).predicted_m + residual_m;
  const double wild_m2 = settings_.wild_sigma_m * settings_.wild_sigma_m;
  for (Slice& s : slices_) {
    const Expected e = expected(s, sight, bias);
    const double nu = measured_m - e.range_m;
    const double S = e.variance_m2 + R_m2;
    learn(s, sight, bias, measured_m, R_m2, learns_across);
    if (!learns_across) continue;
    const double likelihood = (1.0 - settings_.wild_fraction) * gauss(nu, S) +
                              settings_.wild_fraction * gauss(nu, S + wild_m2);
    s.log_weight += std::log(std::max(1e-300, likelihood));
  }
  normalise();
}

/// A range with much more information than the prior moves the slice far, to where the
/// linearisation differs. So it is applied in parts, each linearised at the result of the last one.
/// For a linear distance the parts add up to the whole.
void LandmarkMixture::learn(Slice& s, const MixtureSight& sight, int bias, double measured_m,
                            double R_m2, bool learns_across) {
  double reported = 0.0;
  for (;;) {
    const Expected e = expected(s, sight, bias);
    const double untold = 1.0 / (R_m2 + e.bend_m2) - reported;
    if (untold <= 0.0) return;
    const double known = 1.0 / std::max(1e-9, e.variance_m2 - e.bend_m2);
    const double part = untold < kMuch * known ? untold : known;
    reported += part;
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

void LandmarkMixture::normalise() {
  double maximum = -1e300;
  for (const Slice& s : slices_) maximum = std::max(maximum, s.log_weight + s.log_passage);
  double sum = 0.0;
  for (Slice& s : slices_) {
    s.weight = std::exp(s.log_weight + s.log_passage - maximum);
    sum += s.weight;
  }
  for (Slice& s : slices_) {
    s.weight /= sum;
    s.log_weight -= maximum;
  }
  const double minimum = settings_.weight_min / static_cast<double>(slices_.size());
  std::erase_if(slices_, [minimum](const Slice& s) { return s.weight < minimum; });
  sum = 0.0;
  for (const Slice& s : slices_) sum += s.weight;
  for (Slice& s : slices_) s.weight /= sum;
}

LandmarkMixture::Vector LandmarkMixture::mean() const {
  Vector out = Vector::Zero(size());
  for (const Slice& s : slices_) out += s.weight * s.mean;
  return out;
}

LandmarkMixture::Matrix LandmarkMixture::covariance() const {
  const Vector middle = mean();
  Matrix out = Matrix::Zero(size(), size());
  for (const Slice& s : slices_) {
    const Vector d = s.mean - middle;
    out += s.weight * (s.covariance + d * d.transpose());
  }
  return out;
}

double LandmarkMixture::likeliest_across_m() const {
  const auto best =
      std::max_element(slices_.begin(), slices_.end(),
                       [](const Slice& a, const Slice& b) { return a.weight < b.weight; });
  return best->mean[kAcross];
}

void LandmarkMixture::take_side() {
  // Adjacent slices are one side: the nearest ranges have left none between the sides.
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
  double uncertainty_m2 = 0.0;
  for (auto s = slices_.begin(); s != slices_.end(); ++s) {
    if (s >= first && s < last) continue;
    const double off_m = s->mean[kAcross] - best_m;
    uncertainty_m2 += s->weight * off_m * off_m;
  }
  slices_ = std::vector<Slice>(first, last);
  for (Slice& s : slices_) s.covariance(kAcross, kAcross) += uncertainty_m2;
  normalise();
}

void LandmarkMixture::recentre() {
  last_ = covariance();
  const Vector middle = mean();
  for (Slice& s : slices_) s.mean -= middle;
}

}  // namespace rali::ranging
