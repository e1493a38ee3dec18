#include "rali/ranging/excess_watch.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace rali::ranging {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void ExcessWatch::reset() {
  recent_m_.clear();
  pending_m_.clear();
  t_excess_.reset();
}

double ExcessWatch::level() const {
  return median(std::vector<double>(recent_m_.begin(), recent_m_.end()));
}

/// A step must exceed the noise of the samples, as measured from one to the next, and a smallest
/// step that matters.
double ExcessWatch::limit(double sigma_m) const {
  double noise_m = sigma_m;
  if (steps_m_.size() >= static_cast<std::size_t>(settings_.noise_samples)) {
    std::vector<double> sizes;
    for (const double d : steps_m_) sizes.push_back(std::abs(d));
    constexpr double kSigmaOfMedian = 1.4826;
    noise_m = std::min(sigma_m, kSigmaOfMedian * median(std::move(sizes)) / std::sqrt(2.0));
  }
  return std::max(settings_.step_min_m, settings_.step_sigmas * noise_m);
}

ExcessVerdict ExcessWatch::look(Time t, double nu_m, double sigma_m, double pose_sigma_m,
                                double turn_sigma_m) {
  if (!std::isfinite(nu_m)) return ExcessVerdict::kNone;
  const bool gap = t_last_ && seconds_between(*t_last_, t) > settings_.gap_s;
  if (gap) reset();
  t_last_ = t;
  const double limit_m = std::hypot(limit(sigma_m), settings_.step_sigmas * turn_sigma_m);
  if (t_excess_) return in_excess(t, nu_m, limit_m, pose_sigma_m);
  if (recent_m_.size() < static_cast<std::size_t>(settings_.level_min)) {
    follow(nu_m);
    return ExcessVerdict::kNone;
  }
  return pending(t, nu_m, limit_m);
}

/// One sample far off is an outlier; several on the same side are a step.
ExcessVerdict ExcessWatch::pending(Time t, double nu_m, double limit_m) {
  const double off_m = nu_m - level();
  const bool far = std::abs(off_m) > limit_m;
  const bool same_side = pending_m_.empty() || (off_m > 0.0) == (pending_m_.back() > level());
  if (!far || !same_side) pending_m_.clear();
  // A slow drift comes from the pose, not from the signal path.
  const bool jumped = !pending_m_.empty() || std::abs(nu_m - recent_m_.back()) > 0.6 * limit_m;
  if (!far || !jumped) {
    follow(nu_m);
    return ExcessVerdict::kNone;
  }
  pending_m_.push_back(nu_m);
  if (pending_m_.size() < static_cast<std::size_t>(settings_.step_samples)) {
    return ExcessVerdict::kWaiting;
  }
  step_m_ = median(std::vector<double>(pending_m_.begin(), pending_m_.end())) - level();
  recent_m_.assign(pending_m_.begin(), pending_m_.end());
  pending_m_.clear();
  if (step_m_ < 0.0) return ExcessVerdict::kRelieved;
  t_excess_ = t;
  return ExcessVerdict::kExcess;
}

/// It ends with a step down, when the pose has become as uncertain as the excess is large, or when
/// it has lasted longer than obstacles do. The level follows meanwhile: the speed is not known
/// exactly.
ExcessVerdict ExcessWatch::in_excess(Time t, double nu_m, double limit_m, double pose_sigma_m) {
  const double down_m = level() - nu_m;
  const bool over = down_m > std::max(limit_m, settings_.end_fraction * step_m_);
  const bool assumed = seconds_between(*t_excess_, t) > settings_.longest_s ||
                       pose_sigma_m > settings_.uncertainty_factor * step_m_;
  if (over) {
    pending_m_.push_back(nu_m);
  } else {
    pending_m_.clear();
    follow(nu_m);
  }
  const bool ended = pending_m_.size() >= static_cast<std::size_t>(settings_.step_samples);
  if (!ended && !assumed) return ExcessVerdict::kExcess;
  reset();
  follow(nu_m);
  return ExcessVerdict::kNone;
}

void ExcessWatch::follow(double nu_m) {
  if (!recent_m_.empty()) steps_m_.push_back(nu_m - recent_m_.back());
  recent_m_.push_back(nu_m);
  if (recent_m_.size() > static_cast<std::size_t>(settings_.level_samples)) recent_m_.pop_front();
  if (steps_m_.size() > static_cast<std::size_t>(settings_.noise_window)) steps_m_.pop_front();
}

}  // namespace rali::ranging
