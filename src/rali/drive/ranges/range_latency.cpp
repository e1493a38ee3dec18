#include "rali/drive/ranges/range_latency.hpp"

#include <cmath>

#include <fmt/format.h>

namespace rali::drive {
namespace {

/// A posterior sigma above this fraction of the prior's means that the offset was not observed: the
/// motion's own sigma exceeds five times the prior's.
constexpr double kKnownFraction = 0.98;

}  // namespace

std::optional<RangeLatency> latency_by_motion(
    const std::optional<vehicle::RangeStampOffset>& offset, double prior_sigma_s) {
  if (!offset || !(offset->sigma_s > 0.0) || !std::isfinite(offset->value_s)) return std::nullopt;
  if (!(offset->sigma_s < kKnownFraction * prior_sigma_s)) return std::nullopt;
  // Posterior = prior of mean 0 and motion, each by its information: the prior is removed again.
  const double posterior = 1.0 / (offset->sigma_s * offset->sigma_s);
  const double motion = posterior - 1.0 / (prior_sigma_s * prior_sigma_s);
  return RangeLatency{-offset->value_s * posterior / motion, 1.0 / std::sqrt(motion)};
}

std::optional<RangeLatency> combined(std::span<const std::optional<RangeLatency>> vehicles) {
  double information = 0.0, sum = 0.0;
  for (const std::optional<RangeLatency>& v : vehicles) {
    if (!v || !v->sigma_s) continue;
    const double w = 1.0 / (*v->sigma_s * *v->sigma_s);
    information += w;
    sum += w * v->value_s;
  }
  if (!(information > 0.0)) return std::nullopt;
  return RangeLatency{sum / information, 1.0 / std::sqrt(information)};
}

std::string latency_words(const RangeLatency& latency) {
  std::string words = fmt::format("{:.0f} ms", 1e3 * latency.value_s);
  if (latency.sigma_s) words += fmt::format(", sigma {:.1f} ms", 1e3 * *latency.sigma_s);
  return words;
}

}  // namespace rali::drive
