#include "rali/ranging/paper_smoother.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace rali::ranging {
namespace {

/// Sd of normal errors by their median absolute deviation.
constexpr double kSdPerMad = 1.4826;
/// More samples than any radio delivers in a window: earlier ones are dropped.
constexpr std::size_t kMaxSamples = 4096;

/// Smaller pivots of the normal equations mean that the times do not determine this order.
constexpr double kMinPivot = 1e-9;

/// Polynomial in t - origin.
struct Fit {
  Eigen::Vector3d coefficients = Eigen::Vector3d::Zero();
  double variance = 1.0;  ///< of its value at the origin, for samples of variance 1

  [[nodiscard]] double at(double t_s) const {
    return coefficients.x() + t_s * (coefficients.y() + t_s * coefficients.z());
  }
};

int order_of(PaperSmoother smoother) {
  switch (smoother) {
    case PaperSmoother::kLine:
      return 1;
    case PaperSmoother::kQuadratic:
      return 2;
    case PaperSmoother::kMean:
    case PaperSmoother::kNone:
      break;
  }
  return 0;
}

/// Least squares by normal equations of the given order, or of the highest lower one that the times
/// determine. `scale_s` brings times to about 1, so that the equations are well scaled.
template <class Samples>
Fit fit(const Samples& samples, Time origin, int order, double scale_s) {
  order = std::min(order, static_cast<int>(samples.size()) - 1);
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& s : samples) {
    const double x = seconds_between(origin, s.t) / scale_s;
    const Eigen::Vector3d row(1.0, x, x * x);
    A += row * row.transpose();
    b += row * s.range_m;
  }
  Fit out;
  for (; order > 0; --order) {
    const int n = order + 1;
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(A.topLeftCorner(n, n));
    if (ldlt.vectorD().minCoeff() < kMinPivot) continue;  // too few different times
    out.coefficients.head(n) = ldlt.solve(b.head(n));
    out.variance = ldlt.solve(Eigen::VectorXd::Unit(n, 0))(0);
    out.coefficients.y() /= scale_s;
    out.coefficients.z() /= scale_s * scale_s;
    return out;
  }
  out.coefficients.x() = b.x() / A(0, 0);
  out.variance = 1.0 / A(0, 0);
  return out;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace

PaperRangeSmoother::PaperRangeSmoother(const PaperRangeSettings& settings) : settings_(settings) {}

std::optional<SmoothedRange> PaperRangeSmoother::add(Time t, double range_m) {
  if (!std::isfinite(range_m)) return std::nullopt;
  make_room(t);
  samples_.push_back({t, range_m});
  const double variance_m2 = settings_.range_sigma_m * settings_.range_sigma_m;
  if (settings_.smoother == PaperSmoother::kNone) return SmoothedRange{t, range_m, variance_m2, 1};
  const std::vector<Sample> kept = without_outliers();
  const Fit line = fit(kept, t, order_of(settings_.smoother), settings_.smoother_s);
  return SmoothedRange{t, line.coefficients.x(), line.variance * variance_m2,
                       static_cast<int>(kept.size())};
}

void PaperRangeSmoother::make_room(Time t) {
  if (samples_.empty()) return;
  const double gap_s = seconds_between(samples_.back().t, t);
  if (gap_s < 0.0 || gap_s > 0.5 * settings_.smoother_s) return reset();
  const Time oldest = t - Duration::from_s(settings_.smoother_s);
  auto keep = std::find_if(samples_.begin(), samples_.end(),
                           [&](const Sample& s) { return s.t >= oldest; });
  if (keep == samples_.begin() && samples_.size() >= kMaxSamples) ++keep;
  samples_.erase(samples_.begin(), keep);
}

std::vector<PaperRangeSmoother::Sample> PaperRangeSmoother::without_outliers() const {
  if (samples_.size() < static_cast<std::size_t>(settings_.smoother_outlier_samples)) {
    return samples_;
  }
  const Time newest = samples_.back().t;
  const Fit line = fit(samples_, newest, order_of(settings_.smoother), settings_.smoother_s);
  std::vector<double> residuals;
  for (const Sample& s : samples_) {
    residuals.push_back(s.range_m - line.at(seconds_between(newest, s.t)));
  }
  const double middle = median(residuals);
  std::vector<double> deviations = residuals;
  for (double& d : deviations) d = std::abs(d - middle);
  const double sd_m =
      std::max(kSdPerMad * median(std::move(deviations)), settings_.smoother_outlier_min_m);
  std::vector<Sample> kept;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    // Deviation from the median of the residuals: the gross error itself pulled the line away from
    // the others.
    if (std::abs(residuals[i] - middle) <= settings_.smoother_outlier_sds * sd_m)
      kept.push_back(samples_[i]);
  }
  // A fit with few samples near it does not identify outliers.
  return 2 * kept.size() >= samples_.size() ? kept : samples_;
}

}  // namespace rali::ranging
