#include "rali/inspect/fleet_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kLatencyMax_s = 0.3, kLatencyStep_s = 0.02;
constexpr double kLatencyLimit_s = 0.02, kSigmaMax_s = 0.03;
constexpr std::size_t kRangesMin = 40;
constexpr double kDriven_m = 3.0;    ///< minimum extent of a moving track
constexpr double kStanding_m = 0.3;  ///< maximum extent at standstill: LiDAR odometry drifts
constexpr double kTrackGap_s = 0.5;
constexpr double kRangeScale_m = 0.15;  ///< residuals beyond it are increasingly downweighted
constexpr double kBiasSigma_m = 0.5;
constexpr double kHeightSigma_m = 3.0;  ///< a level trajectory does not determine the sign of the
                                        ///< peer's height
constexpr double kOverlapMin_s = 10.0;
constexpr double kBootClock_s = 1e8;  ///< all clocks that count from 1970 are above

using Track = std::span<const drive::TrackPoint>;
using Ranges = std::span<const std::pair<Time, double>>;

double extent_m(Track track) {
  if (track.empty()) return 0.0;
  geometry::Vec3 low = track.front().p_odom_m, high = low;
  for (const drive::TrackPoint& point : track) {
    low = low.cwiseMin(point.p_odom_m);
    high = high.cwiseMax(point.p_odom_m);
  }
  return (high - low).norm();
}

/// The segment between gaps with the longest duration.
Track longest_piece(Track track) {
  Track best;
  for (std::size_t begin = 0; begin < track.size();) {
    std::size_t end = begin;
    while (end < track.size() && track[end].piece == track[begin].piece) ++end;
    const Track piece = track.subspan(begin, end - begin);
    if (best.empty() || seconds_between(piece.front().t, piece.back().t) >
                            seconds_between(best.front().t, best.back().t)) {
      best = piece;
    }
    begin = end;
  }
  return best;
}

/// A range and how to interpolate the track position at its time.
struct Shot {
  Time t;
  double range_m = 0.0;
};

std::optional<geometry::Vec3> position_at(Track track, Time t) {
  const auto after = std::lower_bound(track.begin(), track.end(), t,
                                      [](const drive::TrackPoint& p, Time at) { return p.t < at; });
  if (after == track.begin() || after == track.end()) return std::nullopt;
  const drive::TrackPoint &a = *std::prev(after), &b = *after;
  const double span_s = seconds_between(a.t, b.t);
  if (span_s > kTrackGap_s) return std::nullopt;
  const double s = seconds_between(a.t, t) / span_s;
  return geometry::Vec3(a.p_odom_m + s * (b.p_odom_m - a.p_odom_m));
}

using Vec4 = Eigen::Vector4d;

/// Estimates the peer's position and the range bias, with the residual cost.
class PeerFit {
 public:
  PeerFit(Track track, const std::vector<Shot>& shots, double latency_s) {
    for (const Shot& shot : shots) {
      const auto p = position_at(track, shot.t - Duration::from_s(latency_s));
      if (p) samples_.push_back({*p, shot.range_m});
    }
  }

  /// Linear start, then reweighted Gauss-Newton. False if there are too few samples.
  bool solve() {
    if (samples_.size() < kRangesMin) return false;
    start();
    for (int i = 0; i < 15; ++i) step();
    return x_.allFinite();
  }

  [[nodiscard]] double cost() const {
    double sum = 0.0;
    for (const Sample& s : samples_) {
      const double e = residual_m(s) / kRangeScale_m;
      sum += std::log1p(e * e);
    }
    return sum / static_cast<double>(samples_.size());
  }

  [[nodiscard]] double rms_m() const {
    double sum = 0.0, weight = 0.0;
    for (const Sample& s : samples_) {
      const double e = residual_m(s), w = weight_of(e);
      sum += w * e * e;
      weight += w;
    }
    return std::sqrt(sum / weight);
  }

  [[nodiscard]] std::size_t size() const { return samples_.size(); }

 private:
  struct Sample {
    geometry::Vec3 p_m;
    double range_m;
  };

  [[nodiscard]] double residual_m(const Sample& s) const {
    return (s.p_m - x_.head<3>()).norm() + x_[3] - s.range_m;
  }

  [[nodiscard]] static double weight_of(double residual_m) {
    const double e = residual_m / kRangeScale_m;
    return 1.0 / (1.0 + e * e);
  }

  /// r^2 - |p|^2 = -2 p a + (|a|^2), linear in the peer position a and its squared norm.
  void start() {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Vec4 b = Vec4::Zero();
    H(2, 2) = 1e-3 * static_cast<double>(samples_.size());
    for (const Sample& s : samples_) {
      const double scale = 1.0 / std::max(0.5, 2.0 * s.range_m);
      Vec4 row;
      row << -2.0 * s.p_m, 1.0;
      row *= scale;
      H += row * row.transpose();
      b += row * scale * (s.range_m * s.range_m - s.p_m.squaredNorm());
    }
    x_.head<3>() = H.ldlt().solve(b).head<3>();
    x_[3] = 0.0;
  }

  void step() {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    const double noise = kRangeScale_m * kRangeScale_m;
    Vec4 b = Vec4::Zero();
    H(3, 3) = noise / (kBiasSigma_m * kBiasSigma_m);
    b[3] = -H(3, 3) * x_[3];
    H(2, 2) = noise / (kHeightSigma_m * kHeightSigma_m);
    b[2] = -H(2, 2) * x_[2];
    for (const Sample& s : samples_) {
      const geometry::Vec3 d = x_.head<3>() - s.p_m;
      Vec4 J;
      J << d / std::max(d.norm(), 1e-3), 1.0;
      const double e = residual_m(s), w = weight_of(e);
      H += w * J * J.transpose();
      b -= w * e * J;
    }
    x_ += H.ldlt().solve(b);
  }

  std::vector<Sample> samples_;
  Vec4 x_ = Vec4::Zero();  ///< position [m], bias [m]
};

/// Ranges whose time is within the track for all tested latencies.
std::vector<Shot> shots_within(Track track, Ranges ranges) {
  const Duration margin = Duration::from_s(kLatencyMax_s + kLatencyStep_s);
  std::vector<Shot> shots;
  for (const auto& [t, range_m] : ranges) {
    const bool inside = t - margin >= track.front().t && t + margin <= track.back().t;
    if (inside) shots.push_back({t, range_m});
  }
  return shots;
}

/// One vehicle's recordings, combined.
struct Vehicle {
  std::string name;
  Time t_start, t_end;
  Track track;
};

std::vector<Vehicle> vehicles_of(const std::vector<DoctorReport>& recordings) {
  std::vector<Vehicle> vehicles;
  for (const DoctorReport& r : recordings) {
    if (r.t_start == r.t_end) continue;
    const auto known = std::find_if(vehicles.begin(), vehicles.end(),
                                    [&](const Vehicle& v) { return v.name == r.vehicle; });
    if (known == vehicles.end()) {
      vehicles.push_back({r.vehicle, r.t_start, r.t_end, r.track});
      continue;
    }
    known->t_start = std::min(known->t_start, r.t_start);
    known->t_end = std::max(known->t_end, r.t_end);
    if (extent_m(known->track) < extent_m(r.track)) known->track = r.track;
  }
  return vehicles;
}

void report_pair(const Vehicle& a, const Vehicle& b, const RangeStudy& study, FindingList& out) {
  const auto ranges = study.between(a.name, b.name);
  if (ranges.empty()) return;
  std::optional<LatencyByMotion> found;
  for (const auto& [driver, peer] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    if (peer->track.empty() || extent_m(peer->track) > kStanding_m) continue;
    found = latency_by_motion(driver->track, ranges);
    if (found) break;
  }
  const std::string pair = a.name + '-' + b.name;
  if (!found) {
    out.push_back(make_finding(
        "D16", Severity::kInfo, "",
        {fmt::format("{}: latency of the ranges not observable in what was looked at", pair), "",
         "Let one vehicle stand while the other drives past it, with walls in view."}));
    return;
  }
  const bool late = std::abs(found->latency_s) > std::max(kLatencyLimit_s, 3.0 * found->sigma_s);
  out.push_back(make_finding(
      "D16", late ? Severity::kWarning : Severity::kInfo, "",
      {fmt::format(
           "{}: ranges are {:.0f} ms old at their stamps (sigma {:.0f} ms, {} ranges, {:.2f} "
           "m left)",
           pair, 1e3 * found->latency_s, 1e3 * found->sigma_s, found->ranges, found->residual_m),
       late ? "while driving, each range is off by latency times speed" : "",
       late ? fmt::format("Leave ranges.latency_s at auto, or set it to {:.3f}.", found->latency_s)
            : ""},
      {found->latency_s, kLatencyLimit_s}));
}

void report_stamps(const RangeStudy& study, FindingList& out) {
  for (const auto& [topic, radios] : study.radios()) {
    const bool own = radios.without_stamp == 0;
    out.push_back(make_finding(
        "D16", Severity::kInfo, topic,
        {own ? "ranges carry stamps of their own"
             : "ranges carry no stamps: rali map takes the radio's own clock, set by the arrivals",
         "", ""},
        {static_cast<double>(radios.without_stamp), 0.0}));
  }
}

Finding overlap_finding(const Vehicle& first, const Vehicle& v, bool separate) {
  const double late_s = seconds_between(first.t_start, v.t_start);
  const double together_s =
      seconds_between(std::max(first.t_start, v.t_start), std::min(first.t_end, v.t_end));
  const std::string starts = fmt::format("{} starts {:.1f} s {} {}", v.name, std::abs(late_s),
                                         late_s < 0.0 ? "before" : "after", first.name);
  if (separate) {
    return make_finding("D17", Severity::kInfo, "", {starts + "; clock: separate", "", ""},
                        {late_s, 0.0});
  }
  const bool boot = first.t_start.s() < kBootClock_s || v.t_start.s() < kBootClock_s;
  if (boot && std::abs(late_s) > kBootClock_s) {
    return make_finding(
        "D17", Severity::kError, "",
        {fmt::format(
             "clocks of {} and {} have different origins: stamps begin at {:.0f} s and {:.0f} s",
             first.name, v.name, first.t_start.s(), v.t_start.s()),
         "ranges between them fit no pose", "Synchronise the computers' clocks before recording."},
        {late_s, 0.0});
  }
  // For short recordings, half of the duration is sufficient.
  const double shorter_s =
      std::min(seconds_between(first.t_start, first.t_end), seconds_between(v.t_start, v.t_end));
  const double limit_s = std::min(kOverlapMin_s, 0.5 * shorter_s);
  if (together_s >= limit_s) {
    return make_finding("D17", Severity::kInfo, "",
                        {fmt::format("{}; both run for {:.0f} s", starts, together_s), "", ""},
                        {late_s, limit_s});
  }
  return make_finding(
      "D17", Severity::kWarning, "",
      {together_s > 0.0 ? fmt::format("{}; both run for {:.1f} s only", starts, together_s)
                        : starts + "; the recordings do not overlap in time",
       "ranges between them do not join them",
       "Set clock: separate if they were recorded at different times; else synchronise the "
       "clocks."},
      {together_s, limit_s});
}

}  // namespace

std::optional<LatencyByMotion> latency_by_motion(Track track, Ranges ranges) {
  const Track piece = longest_piece(track);
  if (piece.empty() || extent_m(piece) < kDriven_m) return std::nullopt;
  const std::vector<Shot> shots = shots_within(piece, ranges);
  constexpr int kHalf = static_cast<int>(kLatencyMax_s / kLatencyStep_s + 0.5);
  std::vector<double> costs;
  for (int k = -kHalf; k <= kHalf; ++k) {
    PeerFit fit(piece, shots, k * kLatencyStep_s);
    if (!fit.solve()) return std::nullopt;
    costs.push_back(fit.cost());
  }
  const auto best = std::min_element(costs.begin(), costs.end());
  if (best == costs.begin() || std::next(best) == costs.end()) return std::nullopt;
  const double before = *std::prev(best), after = *std::next(best);
  const double bend = before - 2.0 * *best + after;
  if (!(bend > 0.0)) return std::nullopt;
  LatencyByMotion out;
  const double index = static_cast<double>(best - costs.begin()) - kHalf;
  out.latency_s = kLatencyStep_s * (index + 0.5 * (before - after) / bend);
  PeerFit fit(piece, shots, out.latency_s);
  if (!fit.solve()) return std::nullopt;
  out.residual_m = fit.rms_m();
  out.ranges = fit.size();
  // The cost per range is log(1 + e^2), near e^2 for inliers. Its curvature over n ranges gives the
  // information once the scale equals that of the residuals.
  const double scale = out.residual_m / kRangeScale_m;
  const double information = 0.5 * static_cast<double>(out.ranges) * bend /
                             (kLatencyStep_s * kLatencyStep_s) / (scale * scale);
  out.sigma_s = 1.0 / std::sqrt(information);
  if (!(out.sigma_s < kSigmaMax_s)) return std::nullopt;
  return out;
}

void report_latency(const std::vector<DoctorReport>& recordings, const RangeStudy& ranges,
                    FindingList& out) {
  const std::vector<Vehicle> vehicles = vehicles_of(recordings);
  for (std::size_t b = 0; b < vehicles.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) report_pair(vehicles[a], vehicles[b], ranges, out);
  }
  report_stamps(ranges, out);
}

void report_overlap(const std::vector<DoctorReport>& recordings, bool separate, FindingList& out) {
  const std::vector<Vehicle> vehicles = vehicles_of(recordings);
  for (std::size_t i = 1; i < vehicles.size(); ++i) {
    out.push_back(overlap_finding(vehicles.front(), vehicles[i], separate));
  }
}

}  // namespace rali::inspect
