#include "rali/fleet/frames/pair_track.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace rali::fleet {

namespace {

bool usable(const RangeObservation& o) {
  return o.x_a_m.allFinite() && o.y_b_m.allFinite() && o.x_covariance_m2.allFinite() &&
         o.y_covariance_m2.allFinite() && std::isfinite(o.range_m) && o.range_m > 0.0 &&
         std::isfinite(o.sigma_m) && o.sigma_m > 0.0;
}

/// Distance travelled by both ends.
double moved_m(const RangeObservation& from, const RangeObservation& to) {
  return (to.x_a_m - from.x_a_m).norm() + (to.y_b_m - from.y_b_m).norm();
}

}  // namespace

TrackUse PairTrack::add(const RangeObservation& o) {
  if (!usable(o)) return TrackUse::kRefused;
  if (!samples_.empty() && o.t < samples_.back().t) return TrackUse::kRefused;
  ++received_;
  if (!samples_.empty()) {
    const RangeObservation& last = samples_.back();
    const double since_m = moved_m(last, o);
    if (since_m <= settings_.still_m && since_m < settings_.spacing_m) {
      average(o);
      return TrackUse::kAveraged;
    }
    if (since_m < settings_.spacing_m) return TrackUse::kThinned;
  }
  if (samples_.size() >= static_cast<std::size_t>(settings_.samples_max)) drop_least();
  samples_.push_back(o);
  count_ = 1.0;
  return TrackUse::kKept;
}

/// The direction between neighbours changes by at most the distance travelled per range.
void PairTrack::drop_least() {
  std::size_t least = 0;
  double least_rad = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k + 1 < samples_.size(); ++k) {
    const double turn_rad = moved_m(samples_[k - 1], samples_[k + 1]) / samples_[k].range_m;
    if (turn_rad < least_rad) {
      least_rad = turn_rad;
      least = k;
    }
  }
  samples_.erase(samples_.begin() + static_cast<std::ptrdiff_t>(least));
}

/// The position stays that of the first sample: it differs by less than `still_m`.
void PairTrack::average(const RangeObservation& o) {
  RangeObservation& last = samples_.back();
  count_ += 1.0;
  last.range_m += (o.range_m - last.range_m) / count_;
  last.sigma_m += (o.sigma_m - last.sigma_m) / count_;
  last.a_rests = last.a_rests && o.a_rests;
  last.b_rests = last.b_rests && o.b_rests;
}

PairTrack PairTrack::swapped() const {
  PairTrack other(b_, a_, settings_);
  other.samples_ = samples_;
  other.count_ = count_;
  other.received_ = received_;
  for (RangeObservation& o : other.samples_) {
    std::swap(o.x_a_m, o.y_b_m);
    std::swap(o.x_covariance_m2, o.y_covariance_m2);
    std::swap(o.a_rests, o.b_rests);
  }
  return other;
}

}  // namespace rali::fleet
