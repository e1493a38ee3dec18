#include "rali/report/section/blind_words.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr double kAlong = 0.85, kAcross = 0.5, kUpright = 0.8;
/// Of the blind way: so much of it has one axis, then all of it is named so.
constexpr double kNearlyAll = 0.8;
/// A vehicle that moved less stood: its distance is noise.
constexpr double kStood_m = 1.0;
/// Less than this is not worth a word: a sweep or two.
constexpr double kAmountMin = 0.05;
constexpr double kShareMin = 0.005;

std::size_t index(HeldBy by) { return static_cast<std::size_t>(by); }

double amount(const VehicleView& v, const WayShare& share) { return stood(v) ? share.s : share.m; }

int decimals_of(double value) { return value < 10.0 ? 2 : value < 100.0 ? 1 : 0; }

std::string_view unit_of(const VehicleView& v) { return stood(v) ? "s" : "m"; }

/// "182 of 201 m": both with the decimals of the smaller.
std::string part_words(const VehicleView& v) {
  const double part = amount(v, v.blind_way.blind), all = amount(v, v.blind_way.all);
  const int decimals = std::min(1, decimals_of(std::min(part, all)));
  return fmt::format("{} of {} {}", fixed(part, decimals), fixed(all, decimals), unit_of(v));
}

/// 99.97 % is not all: nothing is rounded to what it is not.
std::string share_words(double share) {
  if (share >= 1.0 - 1e-9) return "all of it";
  if (share > 0.99) return "over 99 % of it";
  return percent(share) + " of it";
}

/// ", constrained by ranges to v1 for 97 % of it and by inertia alone for 2 %"
std::string held_words(const VehicleView& v) {
  std::string text;
  const double ranges = held_share(v, HeldBy::kRange), inertia = held_share(v, HeldBy::kImu);
  if (ranges > kShareMin) {
    const std::string from =
        v.blind_way.range_names.empty() ? "" : " to " + names_text(v.blind_way.range_names);
    text += fmt::format(", constrained by ranges{} for {}", from, share_words(ranges));
  }
  if (inertia > kShareMin) {
    text +=
        fmt::format("{} by {} for {}", text.empty() ? ", constrained" : " and",
                    stood(v) ? "inertia and standstill" : "inertia alone", share_words(inertia));
  }
  return text;
}

std::string off_words(const VehicleView& v, const OffPeak& peak) {
  if (!std::isfinite(peak.off_m)) return "how large the error is there is not known";
  return fmt::format("the expected error there is {} {} (1 sigma)", metres(peak.off_m),
                     axis_words(v));
}

std::string peak_words(const VehicleView& v) {
  const OffPeak& peak = v.blind_way.peak;
  if (!std::isfinite(peak.off_m)) return "; how large the error is there is not known";
  return fmt::format("; the expected error there is at most {} {}, at {} s (1 sigma)",
                     metres(peak.off_m), axis_words(v), fixed(peak.t_s, 0));
}

}  // namespace

std::string_view axis_words(const BlindSpan& span) {
  if (!(span.axis.norm() > 0.5)) return "along an axis that is not known";
  if (std::abs(span.axis.z()) > kUpright) return "up and down";
  if (span.along_way >= kAlong) return "along its path";
  if (span.along_way <= kAcross) return "across its path";
  return std::isfinite(span.along_way) ? "oblique to its path" : "along a level axis";
}

std::string_view axis_words(const VehicleView& v) {
  std::map<std::string_view, double> weights;
  double sum = 0.0;
  for (const BlindSpan& span : v.blind) {
    const double weight = stood(v) ? span.end_s - span.begin_s : span.way_m;
    weights[axis_words(span)] += weight;
    sum += weight;
  }
  for (const auto& [words, weight] : weights) {
    if (weight > 0.0 && weight >= kNearlyAll * sum) return words;
  }
  return "along one axis";
}

bool blindness_known(const VehicleView& v) {
  return v.blind_way.known || v.numbers.blind_share.has_value();
}

bool was_blind(const VehicleView& v) {
  return v.blind_way.known ? !v.blind.empty() : v.numbers.blind_share.value_or(0.0) > 0.0;
}

bool stood(const VehicleView& v) { return v.blind_way.all.m < kStood_m; }

double held_share(const VehicleView& v, HeldBy by) {
  const double blind = amount(v, v.blind_way.blind);
  return blind > 0.0 ? amount(v, v.blind_way.held[index(by)]) / blind : 0.0;
}

double unheld_share(const VehicleView& v) {
  if (!v.blind_way.known) {
    return v.numbers.blind_share.value_or(0.0) * (1.0 - v.numbers.blind_held_share.value_or(0.0));
  }
  const double all = amount(v, v.blind_way.all);
  return all > 0.0 ? amount(v, v.blind_way.held[index(HeldBy::kNothing)]) / all : 0.0;
}

std::string amount_words(const VehicleView& v, const WayShare& share) {
  const double value = amount(v, share);
  return fixed(value, std::min(1, decimals_of(value))) + ' ' + std::string(unit_of(v));
}

std::string unheld_words(const VehicleView& v) {
  const BlindWay& way = v.blind_way;
  const double nothing = amount(v, way.held[index(HeldBy::kNothing)]);
  const bool everywhere = held_share(v, HeldBy::kNothing) > 1.0 - kShareMin;
  const std::string where =
      everywhere ? "there" : "for " + amount_words(v, way.held[index(HeldBy::kNothing)]);
  return nothing < kAmountMin
             ? std::string()
             : fmt::format("nothing constrained it {}: {}", where, off_words(v, way.peak_nothing));
}

std::string blind_sentence_of(const VehicleView& v) {
  if (!v.blind_way.known) {
    const double held = v.numbers.blind_held_share.value_or(0.0);
    return fmt::format("{} was degenerate on {} of its path, {}", escaped(v.name),
                       percent(v.numbers.blind_share),
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
