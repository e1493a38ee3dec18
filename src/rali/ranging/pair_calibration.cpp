#include "rali/ranging/pair_calibration.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace rali::ranging {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Multipath and the antennas' patterns change over about this distance.
constexpr double kSpacingM = 1.0;
constexpr std::size_t kSamplesMax = 100;
constexpr int kIterations = 10;
constexpr double kStop = 1e-6;  // [m, rad]
constexpr double kHuber = 2.0;  // sigmas; an obstructed range is too long by any amount
/// Smallest sigma: without it the equations could be singular [m, rad].
constexpr double kSigmaMin = 1e-4;
constexpr double kNear = 1e-3;  // [m]; no direction

double square(double x) { return x * x; }

Vec3 turned(const Vec3& v, double yaw_rad) { return Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()) * v; }

}  // namespace

PairCalibration::PairCalibration(const PairPrior& prior) : prior_(prior) {
  Vector sigma;
  sigma << prior.sigma_m, prior.sigma_m, prior.sigma_rad, prior.constant_sigma_m, 0.0, 0.0;
  covariance_ = sigma.cwiseMax(kSigmaMin).cwiseAbs2().asDiagonal();
}

void PairCalibration::start_stay(const Vec3& place_m, const Mat3& covariance_m2) {
  end_stay();
  place_m_ = place_m;
  Eigen::Matrix2d place = 0.5 * (covariance_m2 + covariance_m2.transpose()).topLeftCorner<2, 2>();
  place.diagonal().array() += square(kSigmaMin);
  covariance_.bottomRightCorner<2, 2>() = place;
  before_ = mean_;
  information_before_ = covariance_.ldlt().solve(Matrix::Identity());
}

void PairCalibration::end_stay() {
  place_m_.reset();
  samples_.clear();
  mean_.tail<2>().setZero();
  covariance_.rightCols<2>().setZero();
  covariance_.bottomRows<2>().setZero();
  covariance_.diagonal().tail<2>().setConstant(square(kSigmaMin));
}

bool PairCalibration::add(const Vec3& p_m, double range_m) {
  if (!place_m_ || !p_m.allFinite() || !std::isfinite(range_m)) return false;
  if (!samples_.empty() && (samples_.back().p_m - p_m).norm() < kSpacingM) return false;
  if (samples_.size() >= kSamplesMax) samples_.erase(samples_.begin());
  samples_.push_back({p_m, range_m});
  solve();
  return true;
}

double PairCalibration::constant_sigma_m() const {
  return std::sqrt(std::max(0.0, covariance_(kConstant, kConstant)));
}

Vec3 PairCalibration::place_m() const { return place_at(mean_); }

double PairCalibration::variance_m2(const Vec3& p_m) const {
  const Vector h = derivative(mean_, p_m);
  return std::max(0.0, h.dot(covariance_ * h));
}

/// The frame's error rotates the position about the peer's first one and shifts it.
Vec3 PairCalibration::place_at(const Vector& x) const {
  const Vec3 shift(x(kX) + x(kPlaceX), x(kY) + x(kPlaceY), 0.0);
  return prior_.origin_m + shift + turned(*place_m_ - prior_.origin_m, x(kHeading));
}

/// Derivative of distance plus constant by the unknowns.
PairCalibration::Vector PairCalibration::derivative(const Vector& x, const Vec3& p_m) const {
  const Vec3 place = place_at(x);
  const Vec3 line = place - p_m;
  const Vec3 sight = line / std::max(line.norm(), kNear);
  const Vec3 arm = turned(*place_m_ - prior_.origin_m, x(kHeading));
  Vector h;
  h << sight.x(), sight.y(), sight.dot(Vec3::UnitZ().cross(arm)), 1.0, sight.x(), sight.y();
  return h;
}

/// Solves for all ranges of the stay and the prior before it, by Gauss-Newton with Huber's weights.
void PairCalibration::solve() {
  Vector x = mean_;
  Matrix H = information_before_;
  for (int k = 0; k < kIterations; ++k) {
    H = information_before_;
    Vector g = information_before_ * (x - before_);
    for (const Sample& s : samples_) {
      const double r = (place_at(x) - s.p_m).norm() + x(kConstant) - s.range_m;
      const double sigmas = std::abs(r) / prior_.range_sigma_m;
      const double weight = std::min(1.0, kHuber / std::max(sigmas, kHuber));
      const double information = weight / square(prior_.range_sigma_m);
      const Vector h = derivative(x, s.p_m);
      H += information * h * h.transpose();
      g += information * r * h;
    }
    const Vector step = -H.ldlt().solve(g);
    if (!step.allFinite()) return;
    x += step;
    if (step.cwiseAbs().maxCoeff() < kStop) break;
  }
  mean_ = x;
  covariance_ = H.ldlt().solve(Matrix::Identity());
}

}  // namespace rali::ranging
