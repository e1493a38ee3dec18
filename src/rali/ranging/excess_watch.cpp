#include "rali/ranging/excess_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace rali::ranging {
namespace {

/// Four sds of the errors of ranges that change within seconds, by reflections.
constexpr double kSlow_m = 0.2;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void ExcessWatch::reset() {
  seen_.clear();
  pending_.clear();
  passing_.clear();
  t_excess_.reset();
}

/// A step must exceed the noise of the samples, as measured from one to the next, and a smallest
/// step that matters.
double ExcessWatch::limit(double sigma_m) const {
  double noise_m = sigma_m;
  if (changes_m_.size() >= static_cast<std::size_t>(settings_.noise_samples)) {
    constexpr double kSigmaOfMedian = 1.4826;
    const double size_m = median(std::vector<double>(changes_m_.begin(), changes_m_.end()));
    noise_m = std::min(sigma_m, kSigmaOfMedian * size_m / std::sqrt(2.0));
  }
  return std::max(settings_.step_min_m, settings_.step_sigmas * noise_m);
}

ExcessVerdict ExcessWatch::look(const ExcessSample& sample) {
  if (!std::isfinite(sample.range_m) || !std::isfinite(sample.change_m)) {
    return ExcessVerdict::kNone;
  }
  Seen now{sample.t, 0.0};
  if (last_) {
    now.unexplained_m = last_->unexplained_m + sample.range_m - last_range_m_ - sample.change_m;
    if (seconds_between(last_->t, now.t) > settings_.memory_s) reset();
  }
  last_ = now;
  last_range_m_ = sample.range_m;
  if (t_excess_ && passes(now)) return ExcessVerdict::kNone;
  std::optional<Change> change = this->change(now, sample);
  // An excess that becomes a little smaller is not over.
  if (t_excess_ && change && -change->size_m < settings_.end_fraction * step_m_) change.reset();
  if (t_excess_ && (fits_again(sample) || has_returned(sample))) {
    reset();
    follow(now);
    return ExcessVerdict::kNone;
  }
  if (!confirmed(now, change, sample.sigma_m)) {
    // Too small for a step, and it stays: the new level.
    constexpr std::size_t kPendingMax = 27;
    if (pending_.size() >= kPendingMax) restart_at_pending();
    if (!change) follow(now);
    if (t_excess_ && seconds_between(*t_excess_, now.t) > settings_.longest_s) reset();
    if (t_excess_) return ExcessVerdict::kExcess;
    return change && change->far() ? ExcessVerdict::kWaiting : ExcessVerdict::kNone;
  }
  step_m_ = pending_m();
  const Seen before{pending_.front().seen.t,
                    pending_.front().seen.unexplained_m - pending_.front().change.size_m};
  restart_at_pending();
  if (t_excess_) {
    t_excess_.reset();
    return ExcessVerdict::kNone;
  }
  fitting_ = 0;
  if (step_m_ < 0.0) return ExcessVerdict::kRelieved;
  t_excess_ = now.t;
  before_ = before;
  return ExcessVerdict::kExcess;
}

/// Median of the last samples before `end`, and the time of the middle one.
ExcessWatch::Seen ExcessWatch::level_before(std::deque<Seen>::const_iterator end) const {
  const auto n = static_cast<std::ptrdiff_t>(settings_.level_samples);
  const auto begin = end - std::min(n, end - seen_.begin());
  std::vector<double> level_m;
  for (auto seen = begin; seen != end; ++seen) level_m.push_back(seen->unexplained_m);
  return {(begin + (end - begin) / 2)->t, median(std::move(level_m))};
}

/// Against the median of a few earlier samples, the last ones and older ones; nothing if no change
/// reaches half of what noise and motion may explain. Over time, motion that is not known exactly
/// explains more.
std::optional<ExcessWatch::Change> ExcessWatch::change(const Seen& now,
                                                       const ExcessSample& sample) const {
  constexpr std::array<double, 4> kLags_s{0.0, 1.0, 2.0, 4.0};
  constexpr double kConspicuous = 0.5, kJump = 0.6;
  const double noise_m = limit(sample.sigma_m);
  for (const double lag_s : kLags_s) {
    const auto end = std::partition_point(seen_.begin(), seen_.end(), [&](const Seen& seen) {
      return seconds_between(seen.t, now.t) >= lag_s;
    });
    if (end - seen_.begin() < settings_.level_min) return std::nullopt;
    const Seen level = level_before(end);
    const double age_s = seconds_between(level.t, now.t);
    const double change_m = now.unexplained_m - level.unexplained_m;
    // An obstacle that came will go: for its end less is required.
    const bool ends = t_excess_ && change_m < 0.0;
    const double sigmas = (ends ? 0.5 : 1.0) * settings_.step_sigmas;
    const double motion_m = std::hypot(sample.speed_sigma_mps * age_s, sample.turn_sigma_m);
    Change change{change_m, noise_m, sigmas * motion_m};
    const double limit_m = std::hypot(change.noise_m, change.open_m);
    const double jump_m = now.unexplained_m - seen_.back().unexplained_m;
    change.sudden = !pending_.empty() ? pending_.front().change.sudden
                                      : lag_s == 0.0 && std::abs(jump_m) > kJump * limit_m;
    if (std::abs(change_m) > kConspicuous * limit_m) return change;
  }
  return std::nullopt;
}

/// One sample far off is an outlier; several on the same side are a step, if all are far off since
/// the first, or if their median stands out from the noise that is assumed of such medians. The
/// noise from sample to sample does not contain slow errors.
bool ExcessWatch::confirmed(const Seen& now, const std::optional<Change>& change, double sigma_m) {
  const bool same_side = pending_.empty() || (change && (change->size_m > 0.0) ==
                                                            (pending_.back().change.size_m > 0.0));
  if (!change || !same_side) drop_pending();
  if (!change) return false;
  pending_.push_back({now, *change});
  if (pending_.size() < static_cast<std::size_t>(settings_.step_samples)) return false;
  const bool all_far = std::all_of(pending_.begin(), pending_.end(), [](const Pending& p) {
    return p.change.sudden && p.change.far();
  });
  if (all_far) return true;
  constexpr double kMedianToMean = 1.25;  // sds of the two, for normal noise
  const double of_median = kMedianToMean * std::sqrt(1.0 / static_cast<double>(pending_.size()) +
                                                     1.0 / settings_.level_samples);
  const double noise_m = std::min(1.0, of_median) * settings_.step_sigmas * sigma_m;
  return std::abs(pending_m()) > std::hypot(std::max(kSlow_m, noise_m), kSlow_m, change->open_m);
}

/// Several in a row are nearer to the pose than to the pose with the excess, and the pose can tell
/// the two apart.
bool ExcessWatch::fits_again(const ExcessSample& sample) {
  constexpr double kApart_sigmas = 4.0;
  const bool fits = sample.residual_m < 0.5 * step_m_ &&
                    std::hypot(sample.pose_sigma_m, sample.sigma_m) < step_m_ / kApart_sigmas;
  fitting_ = fits ? fitting_ + 1 : 0;
  return fitting_ >= settings_.level_min;
}

/// The last ones are nearer to the level before the excess than to the excess. It may have gone
/// without a step: a few long ranges, or an obstacle that goes gradually.
bool ExcessWatch::has_returned(const ExcessSample& sample) const {
  constexpr double kOpen_sigmas = 2.0;
  if (seen_.size() < static_cast<std::size_t>(settings_.level_samples)) return false;
  const double age_s = seconds_between(before_.t, sample.t);
  const double open_m =
      kOpen_sigmas * std::hypot(sample.speed_sigma_mps * age_s, sample.turn_sigma_m);
  const double above_m = level_before(seen_.end()).unexplained_m - before_.unexplained_m;
  return above_m + open_m < 0.5 * step_m_;
}

/// Whether a range within an excess is at the level before it. Noise alone must not take one of the
/// obstructed there, so it must have come down by most of the step. Many in a row end the excess.
bool ExcessWatch::passes(const Seen& now) {
  constexpr std::size_t kOver = 9;
  constexpr double kDown = 0.7;
  const double level_m = level_before(seen_.end()).unexplained_m;
  const bool passes = now.unexplained_m < level_m - kDown * step_m_;
  if (!passes) {
    passing_.clear();
    return false;
  }
  passing_.push_back(now);
  if (passing_.size() >= kOver) {
    const std::vector<Seen> over = passing_;
    reset();
    seen_.assign(over.begin(), over.end());
  }
  return true;
}

double ExcessWatch::pending_m() const {
  std::vector<double> sizes_m;
  for (const Pending& p : pending_) sizes_m.push_back(p.change.size_m);
  return median(std::move(sizes_m));
}

/// It was no step: all but outliers belong to the level.
void ExcessWatch::drop_pending() {
  for (const Pending& p : pending_) {
    if (!p.change.far()) follow(p.seen);
  }
  pending_.clear();
}

void ExcessWatch::restart_at_pending() {
  seen_.clear();
  for (const Pending& p : pending_) seen_.push_back(p.seen);
  pending_.clear();
}

void ExcessWatch::follow(const Seen& now) {
  if (!seen_.empty()) {
    changes_m_.push_back(std::abs(now.unexplained_m - seen_.back().unexplained_m));
  }
  seen_.push_back(now);
  while (seconds_between(seen_.front().t, now.t) > settings_.memory_s) seen_.pop_front();
  if (changes_m_.size() > static_cast<std::size_t>(settings_.noise_window)) changes_m_.pop_front();
}

}  // namespace rali::ranging
