#include "rali/ranging/stamp_offset.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::ranging {
namespace {

constexpr double kCoarse_s = 0.2, kFine_s = 0.02, kFineHalf_s = 0.3;
/// Of a window, for the coarse search.
constexpr std::size_t kCoarseRanges = 80;
/// Offsets nearer than this are one and the same minimum.
constexpr double kApart_s = 0.5;
/// In units of -2 log likelihood. A window whose ranges came around obstacles must not outvote the
/// others: beyond kContradicts it counts no more. Another offset is excluded from kExcluded on.
constexpr double kContradicts = 50.0, kExcluded = 25.0;
/// Residuals of a fit that no radio reaches [m].
constexpr double kResidualMin_m = 0.02;

/// The ranges that lie on the track for all offsets of the search, so that all offsets are judged
/// by the same ranges.
std::vector<TimedRange> within(const StandWindow& window, double largest_s) {
  std::vector<TimedRange> inside;
  if (window.track.empty()) return inside;
  const Duration margin = Duration::from_s(largest_s);
  for (const TimedRange& range : window.ranges) {
    const bool covered =
        range.t - margin >= window.track.front().t && range.t + margin <= window.track.back().t;
    if (covered) inside.push_back(range);
  }
  return inside;
}

std::vector<StandWindow> thinned(std::span<const StandWindow> windows) {
  std::vector<StandWindow> out;
  for (const StandWindow& window : windows) {
    StandWindow& thin = out.emplace_back(StandWindow{window.track, {}});
    const std::size_t step = 1 + window.ranges.size() / kCoarseRanges;
    for (std::size_t i = 0; i < window.ranges.size(); i += step) {
      thin.ranges.push_back(window.ranges[i]);
    }
  }
  return out;
}

/// Costs at equal steps of the offset.
struct Scan {
  double first_s = 0.0, step_s = 0.0;
  /// [window][step], in units of -2 log likelihood above its least, at most kContradicts.
  std::vector<std::vector<double>> costs;
  std::vector<double> total;  ///< over the windows

  [[nodiscard]] double at_s(std::size_t k) const {
    return first_s + static_cast<double>(k) * step_s;
  }

  [[nodiscard]] std::size_t best() const {
    return static_cast<std::size_t>(std::min_element(total.begin(), total.end()) - total.begin());
  }
};

/// The fits of one window at all offsets; empty if a gap of the track comes into it. The fit has
/// several minima: each offset is also tried from the solutions of its neighbours.
std::vector<PeerFit> fits_of(const StandWindow& window, const Scan& at, std::size_t count) {
  std::vector<PeerFit> fits;
  for (std::size_t k = 0; k < count; ++k) {
    PeerFit fit(window.track, window.ranges, at.at_s(k));
    if (!fit.solve()) return {};
    if (k > 0) fit.try_from(fits.back().state());
    fits.push_back(std::move(fit));
  }
  for (std::size_t k = fits.size(); k-- > 1;) fits[k - 1].try_from(fits[k].state());
  return fits;
}

/// By the noise that the best fit leaves: a cost of log(1 + e^2) is near e^2 for inliers.
std::vector<double> normalised_costs(const std::vector<PeerFit>& fits) {
  std::vector<double> costs;
  for (const PeerFit& fit : fits) costs.push_back(fit.cost());
  const auto best = std::min_element(costs.begin(), costs.end());
  const PeerFit& fit = fits[static_cast<std::size_t>(best - costs.begin())];
  constexpr double kMin = kResidualMin_m * kResidualMin_m / PeerFit::kScale_m / PeerFit::kScale_m;
  const double least = *best;
  const double variance = std::max(kMin, least / static_cast<double>(fit.size())) * fit.alike();
  for (double& cost : costs) cost = std::min(kContradicts, (cost - least) / variance);
  return costs;
}

Scan scan(std::span<const StandWindow> windows, double middle_s, double half_s, double step_s) {
  const int half = static_cast<int>(std::lround(half_s / step_s));
  Scan out;
  out.first_s = middle_s - half * step_s;
  out.step_s = step_s;
  out.total.assign(static_cast<std::size_t>(2 * half + 1), 0.0);
  for (const StandWindow& window : windows) {
    const std::vector<PeerFit> fits = fits_of(window, out, out.total.size());
    if (fits.empty()) continue;
    out.costs.push_back(normalised_costs(fits));
    for (std::size_t k = 0; k < out.total.size(); ++k) out.total[k] += out.costs.back()[k];
  }
  return out;
}

/// Minimum of the parabola through three neighbours, in steps from the middle one.
struct Parabola {
  double bend = 0.0, shift = 0.0;

  Parabola(const std::vector<double>& costs, std::size_t k)
      : bend(costs[k - 1] - 2.0 * costs[k] + costs[k + 1]) {
    if (bend > 0.0) shift = std::clamp(0.5 * (costs[k - 1] - costs[k + 1]) / bend, -10.0, 10.0);
  }
};

/// Variance of the mean by what the windows' own minima disagree by, in steps^2; windows that
/// contradict have a minimum elsewhere and do not count.
double spread(const Scan& scan, std::size_t k, double shift) {
  double sum = 0.0, weight = 0.0;
  int count = 0;
  for (const std::vector<double>& costs : scan.costs) {
    const Parabola own(costs, k);
    if (costs[k] >= kContradicts || !(own.bend > 0.0)) continue;
    sum += own.bend * (own.shift - shift) * (own.shift - shift);
    weight += own.bend;
    ++count;
  }
  return count > 1 ? sum / weight / (count - 1) : 0.0;
}

/// Another offset, apart from the best, that fits almost as well.
bool has_second(const Scan& scan, std::size_t best) {
  for (std::size_t k = 0; k < scan.total.size(); ++k) {
    const bool apart = std::abs(scan.at_s(k) - scan.at_s(best)) > kApart_s;
    if (apart && scan.total[k] - scan.total[best] < kExcluded) return true;
  }
  return false;
}

}  // namespace

std::optional<StampOffset> find_stamp_offset(std::span<const StandWindow> windows, double half_s,
                                             NoOffset* unknown) {
  const auto none = [&](NoOffset why) -> std::optional<StampOffset> {
    if (unknown) *unknown = why;
    return std::nullopt;
  };
  const bool wide = half_s > kFineHalf_s;
  const double largest_s = half_s + (wide ? kFineHalf_s : kFine_s);
  std::vector<StandWindow> inside;
  for (const StandWindow& window : windows) {
    inside.push_back({window.track, within(window, largest_s)});
  }
  const Scan coarse =
      wide ? scan(thinned(inside), 0.0, half_s, kCoarse_s) : scan(inside, 0.0, half_s, kFine_s);
  if (coarse.costs.empty()) return none(NoOffset::kTooLittle);
  std::size_t k = coarse.best();
  if (k == 0 || k + 1 == coarse.total.size()) return none(NoOffset::kBeyond);
  const Scan fine = wide ? scan(inside, coarse.at_s(k), kFineHalf_s, kFine_s) : coarse;
  k = fine.best();
  if (k == 0 || k + 1 == fine.total.size()) return none(NoOffset::kNoMotion);
  const Parabola parabola(fine.total, k);
  if (!(parabola.bend > 0.0)) return none(NoOffset::kNoMotion);
  if (wide && has_second(coarse, coarse.best())) return none(NoOffset::kSeveral);
  StampOffset out;
  out.value_s = fine.at_s(k) + parabola.shift * fine.step_s;
  const double variance = std::max(2.0 / parabola.bend, spread(fine, k, parabola.shift));
  out.sigma_s = fine.step_s * std::sqrt(variance);
  double squares = 0.0;
  for (const StandWindow& window : inside) {
    PeerFit fit(window.track, window.ranges, out.value_s);
    if (!fit.solve()) continue;
    out.ranges += fit.size();
    squares += static_cast<double>(fit.size()) * fit.rms_m() * fit.rms_m();
  }
  if (out.ranges == 0) return none(NoOffset::kTooLittle);
  out.residual_m = std::sqrt(squares / static_cast<double>(out.ranges));
  return out;
}

}  // namespace rali::ranging
