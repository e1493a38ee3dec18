#include "rali/monitor/track_check.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace rali::monitor {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kReferenceGap_s = 1.0;
constexpr double kSameStamp_s = 1e-3;

std::span<const StatedPose>::iterator first_from(std::span<const StatedPose> track, Time t) {
  return std::lower_bound(track.begin(), track.end(), t,
                          [](const StatedPose& pose, Time at) { return pose.t < at; });
}

/// Position and covariance of a track between two of its poses.
std::optional<StatedPose> at(std::span<const StatedPose> track, Time t) {
  const auto after = first_from(track, t);
  if (after == track.end()) return std::nullopt;
  if (after->t == t) return *after;
  if (after == track.begin()) return std::nullopt;
  const StatedPose& before = *(after - 1);
  const double span_s = seconds_between(before.t, after->t);
  if (span_s > kReferenceGap_s) return std::nullopt;
  StatedPose out;
  out.t = t;
  out.T = geometry::interpolate(before.T, after->T, seconds_between(before.t, t) / span_s);
  out.position_covariance = after->position_covariance;
  return out;
}

double sigma_along(const Vec3& direction, const Mat3& covariance) {
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

/// Collects time intervals. Short ones are left out, long ones are divided.
class Stretches {
 public:
  explicit Stretches(const MonitorSettings& settings) : settings_(settings) {}

  void add(Time t, double off_m, double stated_m) {
    if (!open_) open_ = Contradiction{{t, t}, 0.0, 0.0};
    const bool full = seconds_between(open_->when.begin, t) > settings_.part_max_s;
    if (full) {
      list_.push_back(*open_);
      open_ = Contradiction{{open_->when.end, t}, 0.0, 0.0};
      continues_ = true;
    }
    open_->when.end = t;
    if (off_m > open_->off_m || !std::isfinite(off_m)) {
      open_->off_m = off_m;
      open_->stated_m = stated_m;
    }
  }

  void close() {
    if (open_) {
      const double span_s = seconds_between(open_->when.begin, open_->when.end);
      if (continues_ || span_s >= settings_.span_min_s) list_.push_back(*open_);
    }
    open_.reset();
    continues_ = false;
  }

  [[nodiscard]] ContradictionList take() {
    close();
    return std::move(list_);
  }

 private:
  const MonitorSettings& settings_;
  std::optional<Contradiction> open_;
  bool continues_ = false;  ///< the open one is a later part
  ContradictionList list_;
};

}  // namespace

SE3 agreeing_at_first(std::span<const StatedPose> judged, std::span<const StatedPose> reference) {
  for (const StatedPose& pose : judged) {
    const auto same = first_from(reference, pose.t - Duration::from_s(kSameStamp_s));
    if (same == reference.end()) break;
    if (seconds_between(pose.t, same->t) > kSameStamp_s) continue;
    return same->T * pose.T.inverse();
  }
  return {};
}

ContradictionList check_track(std::span<const StatedPose> judged,
                              std::span<const StatedPose> reference, const SE3& T_reference_judged,
                              const MonitorSettings& settings) {
  Stretches stretches(settings);
  for (const StatedPose& pose : judged) {
    const std::optional<StatedPose> truth = at(reference, pose.t);
    if (!truth) continue;
    const Vec3 e = T_reference_judged * pose.T.p - truth->T.p;
    const double off_m = e.norm();
    const Vec3 u = off_m > 0.0 ? Vec3(e / off_m) : Vec3::UnitX();
    const double stated_m =
        sigma_along(T_reference_judged.R.transpose() * u, pose.position_covariance);
    const double reference_m = sigma_along(u, truth->position_covariance);
    // A NaN counts as a contradiction.
    const bool agrees = off_m <= settings.off_min_m || off_m <= settings.sigmas_min * stated_m ||
                        off_m <= reference_m;
    if (agrees) {
      stretches.close();
    } else {
      stretches.add(pose.t, off_m, stated_m);
    }
  }
  return stretches.take();
}

}  // namespace rali::monitor
