#include "rali/report/section/degenerate_words.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr double kAlong = 0.85, kAcross = 0.5, kUpright = 0.8;
/// If one axis covers this fraction of the degenerate distance, it is named for all of it.
constexpr double kNearlyAll = 0.8;
/// A vehicle that moved less was at standstill: its distance is noise.
constexpr double kStood_m = 1.0;
/// Smaller amounts are not mentioned: one or two scans.
constexpr double kAmountMin = 0.05;
constexpr double kFractionMin = 0.005;

std::size_t index(HeldBy by) { return static_cast<std::size_t>(by); }

double amount(const VehicleView& v, const PathFraction& fraction) {
  return stood(v) ? fraction.s : fraction.m;
}

int decimals_of(double value) { return value < 10.0 ? 2 : value < 100.0 ? 1 : 0; }

std::string_view unit_of(const VehicleView& v) { return stood(v) ? "s" : "m"; }

/// "182 of 201 m": both with the decimals of the smaller.
std::string part_words(const VehicleView& v) {
  const double part = amount(v, v.degenerate_path.degenerate),
               all = amount(v, v.degenerate_path.all);
  const int decimals = std::min(1, decimals_of(std::min(part, all)));
  return fmt::format("{} of {} {}", fixed(part, decimals), fixed(all, decimals), unit_of(v));
}

/// 99.97 % is not "all": nothing is rounded up to a complete fraction.
std::string fraction_words(double fraction) {
  if (fraction >= 1.0 - 1e-9) return "all of it";
  if (fraction > 0.99) return "over 99 % of it";
  return percent(fraction) + " of it";
}

/// ", constrained by ranges to v1 for 97 % of it and by inertia alone for 2 %"
std::string held_words(const VehicleView& v) {
  std::string text;
  const double ranges = held_fraction(v, HeldBy::kRange), inertia = held_fraction(v, HeldBy::kImu);
  if (ranges > kFractionMin) {
    const std::string from = v.degenerate_path.range_names.empty()
                                 ? ""
                                 : " to " + names_text(v.degenerate_path.range_names);
    text += fmt::format(", constrained by ranges{} for {}", from, fraction_words(ranges));
  }
  if (inertia > kFractionMin) {
    text +=
        fmt::format("{} by {} for {}", text.empty() ? ", constrained" : " and",
                    stood(v) ? "inertia and standstill" : "inertia alone", fraction_words(inertia));
  }
  return text;
}

std::string off_words(const VehicleView& v, const OffPeak& peak) {
  if (!std::isfinite(peak.off_m)) return "how large the error is there is not known";
  return fmt::format("the expected error there is {} {} (1 sigma)", metres(peak.off_m),
                     axis_words(v));
}

std::string peak_words(const VehicleView& v) {
  const OffPeak& peak = v.degenerate_path.peak;
  if (!std::isfinite(peak.off_m)) return "; how large the error is there is not known";
  return fmt::format("; the expected error there is at most {} {}, at {} s (1 sigma)",
                     metres(peak.off_m), axis_words(v), fixed(peak.t_s, 0));
}

}  // namespace

std::string_view axis_words(const DegenerateSpan& span) {
  if (!(span.axis.norm() > 0.5)) return "along an axis that is not known";
  if (std::abs(span.axis.z()) > kUpright) return "up and down";
  if (span.along_path >= kAlong) return "along its path";
  if (span.along_path <= kAcross) return "across its path";
  return std::isfinite(span.along_path) ? "oblique to its path" : "along a level axis";
}

std::string_view axis_words(const VehicleView& v) {
  std::map<std::string_view, double> weights;
  double sum = 0.0;
  for (const DegenerateSpan& span : v.degenerate) {
    const double weight = stood(v) ? span.end_s - span.start_s : span.path_m;
    weights[axis_words(span)] += weight;
    sum += weight;
  }
  for (const auto& [words, weight] : weights) {
    if (weight > 0.0 && weight >= kNearlyAll * sum) return words;
  }
  return "along one axis";
}

bool blindness_known(const VehicleView& v) {
  return v.degenerate_path.known || v.numbers.degenerate_fraction.has_value();
}

bool was_degenerate(const VehicleView& v) {
  return v.degenerate_path.known ? !v.degenerate.empty()
                                 : v.numbers.degenerate_fraction.value_or(0.0) > 0.0;
}

bool stood(const VehicleView& v) { return v.degenerate_path.all.m < kStood_m; }

double held_fraction(const VehicleView& v, HeldBy by) {
  const double degenerate = amount(v, v.degenerate_path.degenerate);
  return degenerate > 0.0 ? amount(v, v.degenerate_path.held[index(by)]) / degenerate : 0.0;
}

double unheld_fraction(const VehicleView& v) {
  if (!v.degenerate_path.known) {
    return v.numbers.degenerate_fraction.value_or(0.0) *
           (1.0 - v.numbers.degenerate_held_fraction.value_or(0.0));
  }
  const double all = amount(v, v.degenerate_path.all);
  return all > 0.0 ? amount(v, v.degenerate_path.held[index(HeldBy::kNothing)]) / all : 0.0;
}

std::string amount_words(const VehicleView& v, const PathFraction& fraction) {
  const double value = amount(v, fraction);
  return fixed(value, std::min(1, decimals_of(value))) + ' ' + std::string(unit_of(v));
}

std::string unheld_words(const VehicleView& v) {
  const DegeneratePath& path = v.degenerate_path;
  const double nothing = amount(v, path.held[index(HeldBy::kNothing)]);
  const bool everywhere = held_fraction(v, HeldBy::kNothing) > 1.0 - kFractionMin;
  const std::string where =
      everywhere ? "there" : "for " + amount_words(v, path.held[index(HeldBy::kNothing)]);
  return nothing < kAmountMin
             ? std::string()
             : fmt::format("nothing constrained it {}: {}", where, off_words(v, path.peak_nothing));
}

std::string degenerate_sentence_of(const VehicleView& v) {
  if (!v.degenerate_path.known) {
    const double held = v.numbers.degenerate_held_fraction.value_or(0.0);
    return fmt::format("{} was degenerate on {} of its path, {}", escaped(v.name),
                       percent(v.numbers.degenerate_fraction),
                       held > 0.0 ? percent(held) + " of that constrained by ranges"
                                  : std::string("constrained by no range"));
  }
  std::string text =
      fmt::format("{} {}degenerate {} for {}", escaped(v.name),
                  stood(v) ? "stood still and was " : "was ", axis_words(v), part_words(v));
  text += held_words(v);
  const std::string unheld = unheld_words(v);
  return text + (unheld.empty() ? peak_words(v) : "; " + unheld);
}

}  // namespace rali::report
