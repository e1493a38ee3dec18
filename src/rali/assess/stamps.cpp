#include "rali/assess/stamps.hpp"

#include <cmath>

#include <fmt/format.h>

namespace rali::assess {
namespace {

struct Span {
  double start_s, end_s;

  [[nodiscard]] double length_s() const { return end_s - start_s; }
};

Span span_of(const eval::PoseList& poses) { return {poses.front().t.s(), poses.back().t.s()}; }

bool near_factor(double value, double factor) {
  return value > 0.5 * factor && value < 2.0 * factor;
}

/// One of the two trajectories counts in thousandths (millionths, ...) of seconds: its span is
/// longer by that factor.
std::string unit_cause(const Span& est, const Span& ref) {
  const bool est_longer = est.length_s() > ref.length_s();
  const double shorter_s = est_longer ? ref.length_s() : est.length_s();
  const double longer_s = est_longer ? est.length_s() : ref.length_s();
  const char* which = est_longer ? "the estimate's" : "the truth's";
  if (!(shorter_s > 0.0)) return {};
  if (near_factor(longer_s / shorter_s, 1e9)) {
    return fmt::format("{} stamps look like nanoseconds: divide them by 1e9", which);
  }
  if (near_factor(longer_s / shorter_s, 1e6)) {
    return fmt::format("{} stamps look like microseconds: divide them by 1e6", which);
  }
  if (near_factor(longer_s / shorter_s, 1e3)) {
    return fmt::format("{} stamps look like milliseconds: divide them by 1000", which);
  }
  return {};
}

/// Clocks that differ by a known amount.
std::string shift_cause(const Span& est, const Span& ref) {
  constexpr double kUnix_s = 5e8, kDay_s = 86400.0;
  const double shift_s = ref.start_s - est.start_s;
  const double size_s = std::abs(shift_s);
  if ((est.start_s < kUnix_s) != (ref.start_s < kUnix_s)) {
    return fmt::format(
        "{} stamps count from a start of their own, the other's from 1970: "
        "one clock must be taken over to the other",
        est.start_s < kUnix_s ? "the estimate's" : "the truth's");
  }
  const double hours = std::round(size_s / 3600.0);
  // Whole hours up to 14 (the largest time zone); the starts may differ by some seconds.
  if (hours >= 1.0 && hours <= 14.0 && std::abs(size_s - 3600.0 * hours) < 300.0) {
    return fmt::format("the clocks differ by about {:.0f} h: a time zone", hours);
  }
  if (size_s > 0.5 * kDay_s) {
    return fmt::format("they are {:.1f} days apart: another day's recording", size_s / kDay_s);
  }
  return fmt::format(
      "the clocks are shifted, or these are two recordings (their begins are "
      "{:.3f} s apart)",
      size_s);
}

}  // namespace

Error no_common_time(const eval::PoseList& est, const std::string& est_file,
                     const eval::PoseList& truth, const std::string& truth_file,
                     const eval::AssociationOptions& options) {
  const Span e = span_of(est);
  const Span r = span_of(truth);
  std::string cause;
  std::string remedy = "Bring both to one clock.";
  if (e.start_s <= r.end_s && r.start_s <= e.end_s) {
    const bool nearest = options.mode == eval::AssociationMode::kNearest;
    cause = nearest
                ? fmt::format("the spans overlap, but no stamps are within {} s", options.max_dt_s)
                : fmt::format("the spans overlap, but the truth has gaps above {} s",
                              options.max_gap_s);
    remedy = nearest ? "Use --associate interpolate." : "Use --associate nearest:SECONDS.";
  } else {
    cause = unit_cause(e, r);
    if (cause.empty()) cause = shift_cause(e, r);
  }
  return {ErrorCode::kInput,
          fmt::format("no pose has a truth at its time: {} .. {} s against {} .. {} s of {}; {}",
                      fmt::format("{:.3f}", e.start_s), fmt::format("{:.3f}", e.end_s),
                      fmt::format("{:.3f}", r.start_s), fmt::format("{:.3f}", r.end_s), truth_file,
                      cause),
          est_file, remedy};
}

}  // namespace rali::assess
