#include "rali/wire/internal/time_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

// Decides by value, not by name: the same names are used for seconds, microseconds and nanoseconds,
// from the header or from 1970 (users.md section 3). One scan takes 0.015 to 0.6 s with any sensor.
// The four units differ by 1000, so at most one of them gives such a span.
namespace rali::wire::internal {
namespace {

constexpr std::array<std::string_view, 16> kTimeNames = {
    "t",           "time",          "timestamp",  "timeStamp",  "time_stamp",
    "offset_time", "time_offset",   "timestamps", "point_time", "point_time_offset",
    "t_offset",    "relative_time", "rel_time",   "stamp",      "ts",
    "dt"};

constexpr double kSpanMinS = 0.015, kSpanMaxS = 0.6;  ///< of one scan, with gaps and slow ones
constexpr double kSpanSetMaxS = 3.0;  ///< of one scan, even if the unit is set by hand
constexpr double kSpanUsualMinS = 0.018, kSpanUsualMaxS = 0.22;
constexpr double kRelativeMaxS = 1.2;    ///< a larger time has another reference
constexpr double kSameClockS = 1.0;      ///< header and points further apart: two clocks
constexpr std::size_t kDistinctMin = 8;  ///< fewer different times cannot deskew

struct Unit {
  double scale_s;
  std::string_view name;
};

constexpr std::array<Unit, 4> kUnits = {{{1.0, "s"}, {1e-3, "ms"}, {1e-6, "us"}, {1e-9, "ns"}}};

/// Times of the valid points of one cloud without outliers.
struct Span {
  double first = 0.0, last = 0.0;  ///< in units of the field
  std::size_t distinct = 0;
  double header_s = 0.0;
};

/// One field's times over all clouds.
struct TimeValues {
  std::vector<Span> clouds;
  std::size_t valid = 0;  ///< finite values
  bool all_zero = true;
  double span = 0.0;  ///< median over the clouds, in units of the field
  std::size_t distinct = 0;
};

std::optional<Span> span_of(std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double low = values[n / 100], high = values[n - 1 - n / 100];
  // The whole core and its neighbours; a fragmented clock or a stray zero is left out.
  const double margin = 0.5 * (high - low);
  Span span;
  span.first = high;
  span.last = low;
  double previous = 0.0;
  for (const double value : values) {
    if (value < low - margin || value > high + margin) continue;
    span.first = std::min(span.first, value);
    span.last = std::max(span.last, value);
    if (span.distinct == 0 || value != previous) ++span.distinct;
    previous = value;
  }
  return span;
}

TimeValues read_times(const FirstClouds& first, int field) {
  TimeValues times;
  std::vector<double> spans;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    std::vector<double> values = field_values(*cloud.view, cloud.layout, field, cloud.stride);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (cloud.valid[i] == 0 || !std::isfinite(values[i])) continue;
      times.all_zero = times.all_zero && values[i] == 0.0;
      values[kept++] = values[i];
    }
    values.resize(kept);
    times.valid += kept;
    std::optional<Span> span = span_of(values);
    if (!span) continue;
    span->header_s = cloud.view->stamp.s();
    times.distinct = std::max(times.distinct, span->distinct);
    spans.push_back(span->last - span->first);
    times.clouds.push_back(*span);
  }
  times.span = median(spans);
  return times;
}

/// Why a field cannot be the time; empty if it may.
std::string unusable_because(const TimeValues& times, const CloudField& field) {
  if (times.valid == 0) return fmt::format("field '{}' is not a number in any point", field.name);
  if (times.all_zero) return fmt::format("field '{}' is 0 in every point", field.name);
  if (times.span <= 0.0) return fmt::format("field '{}' is the same in every point", field.name);
  if (times.distinct < kDistinctMin) {
    return fmt::format("field '{}' ({}) has only {} different values in a scan", field.name,
                       type_name(field.type), times.distinct);
  }
  return {};
}

const Unit* unit_for(double span, double period_s) {
  for (const Unit& unit : kUnits) {
    const double span_s = span * unit.scale_s;
    const bool possible = span_s >= kSpanMinS && span_s <= kSpanMaxS;
    const bool agrees = period_s <= 0.0 || (span_s >= 0.1 * period_s && span_s <= 1.3 * period_s);
    if (possible && agrees) return &unit;
  }
  return nullptr;
}

/// True if the times have another reference than the scan: large, or growing with the stamps.
bool is_absolute(const TimeValues& times, double scale_s) {
  double largest = 0.0;
  for (const Span& span : times.clouds) {
    largest = std::max({largest, std::abs(span.first), std::abs(span.last)});
  }
  if (largest * scale_s > kRelativeMaxS) return true;
  const Span& a = times.clouds.front();
  const Span& b = times.clouds.back();
  const double grown_s = (b.first - a.first) * scale_s;
  return grown_s > 0.05 && grown_s > 0.5 * (b.header_s - a.header_s);
}

/// Medians over the clouds of first and last time relative to the header [s].
struct AgainstHeader {
  double first_s = 0.0, last_s = 0.0;
};

AgainstHeader against_header(const TimeValues& times, double scale_s, bool absolute) {
  std::vector<double> firsts, lasts;
  for (const Span& span : times.clouds) {
    const double zero = absolute ? span.header_s : 0.0;
    firsts.push_back(span.first * scale_s - zero);
    lasts.push_back(span.last * scale_s - zero);
  }
  return {median(firsts), median(lasts)};
}

void judge_relative(const AgainstHeader& at, const CloudFormatOptions& options, CloudFormat& format,
                    std::string& reported) {
  const double tolerance_s = 0.1 * format.span_s;
  const bool ends = at.last_s <= tolerance_s && at.first_s < -tolerance_s;
  const bool inside = !ends && at.first_s < -tolerance_s;
  format.header_stamp = ends ? HeaderStamp::kEnd : HeaderStamp::kStart;
  if (options.header_stamp == HeaderStamp::kEnd && !ends) {
    format.header_stamp = HeaderStamp::kEnd;
    format.time_shift_s = -at.last_s;
    reported = "stamp = end of scan (set)";
  } else if (options.header_stamp == HeaderStamp::kStart && (ends || inside)) {
    format.header_stamp = HeaderStamp::kStart;
    format.time_shift_s = -at.first_s;
    reported = "stamp = start of scan (set)";
  } else if (ends) {
    reported = "stamp = end of scan (times are negative)";
    format.findings.push_back(cloud_finding(
        "D03", Severity::kInfo,
        fmt::format("the header stamp is the end of the scan: point times run from {:.4f} to "
                    "{:.4f} s",
                    at.first_s, at.last_s),
        {}, {}));
  } else if (inside) {
    reported = fmt::format("stamp lies {:.3f} s after the start of the scan", -at.first_s);
    format.findings.push_back(
        cloud_finding("D03", Severity::kInfo,
                      fmt::format("the header stamp lies within the scan: point times run from "
                                  "{:.4f} to {:.4f} s",
                                  at.first_s, at.last_s),
                      {}, {}));
  } else {
    reported = options.header_stamp == HeaderStamp::kStart ? "stamp = start of scan (set)"
                                                           : "stamp = start of scan";
  }
}

void judge_absolute(const AgainstHeader& at, const FirstClouds& first,
                    const CloudFormatOptions& options, CloudFormat& format, std::string& reported) {
  const bool no_stamps = std::all_of(first.clouds.begin(), first.clouds.end(),
                                     [](const auto& cloud) { return cloud.view->stamp.ns == 0; });
  const double start_s = std::abs(at.first_s), end_s = std::abs(at.last_s);
  format.header_stamp = end_s < start_s ? HeaderStamp::kEnd : HeaderStamp::kStart;
  if (no_stamps) {
    reported = "header stamps are 0, points' times are taken";
    format.findings.push_back(cloud_finding("D03", Severity::kWarning,
                                            "the header stamps of the clouds are 0; the times of "
                                            "the points are taken instead",
                                            {}, {}));
  } else if (std::min(start_s, end_s) <= kSameClockS) {
    const bool close = std::min(start_s, end_s) <= 0.25 * format.span_s;
    if (!close) {
      reported = fmt::format("first point {:+.3f} s from the stamp", at.first_s);
    } else {
      reported = end_s < start_s ? "stamp = end of scan" : "stamp = start of scan";
    }
    if (!close || end_s < start_s) {
      format.findings.push_back(cloud_finding(
          "D03", Severity::kInfo,
          fmt::format("the points' times run from {:+.4f} to {:+.4f} s about the header stamp; the "
                      "points' times are taken",
                      at.first_s, at.last_s),
          {}, {}));
    }
  } else {
    format.anchor_to_header = true;
    format.header_stamp =
        options.header_stamp == HeaderStamp::kEnd ? HeaderStamp::kEnd : HeaderStamp::kStart;
    reported = fmt::format("stamp = {} of scan ({}; the points' clock is another)",
                           format.header_stamp == HeaderStamp::kEnd ? "end" : "start",
                           options.header_stamp == HeaderStamp::kAuto ? "assumed" : "set");
    format.findings.push_back(cloud_finding(
        "D03", Severity::kWarning,
        fmt::format("the points' clock is {:+.3f} s from that of the header stamps; the first "
                    "point is put at the stamp",
                    at.first_s),
        "the scan may lie up to one period too late against the IMU",
        "Set header_stamp if it is the end of the scan; the time offset is estimated."));
  }
}

std::string base_text(bool absolute, const AgainstHeader& at) {
  if (absolute) return "absolute";
  return at.first_s < -1e-3 ? "relative to the header" : "after the header";
}

std::string accept(const FirstClouds& first, int field, const TimeValues& times, const Unit& unit,
                   bool absolute, const CloudFormatOptions& options, CloudFormat& format) {
  const CloudField& chosen = first.fields()[static_cast<std::size_t>(field)];
  format.time = field;
  format.time_scale_s = unit.scale_s;
  format.span_s = times.span * unit.scale_s;
  constexpr std::array kRelative = {PointTime::kRelativeS, PointTime::kRelativeMs,
                                    PointTime::kRelativeUs, PointTime::kRelativeNs};
  const auto index = static_cast<std::size_t>(&unit - kUnits.data());
  format.point_time = kRelative[index];
  if (absolute) {
    // The scale gives the unit; this only marks whole nanoseconds.
    format.point_time = index == 3 ? PointTime::kAbsoluteNs : PointTime::kAbsoluteS;
  }
  const AgainstHeader at = against_header(times, unit.scale_s, absolute);
  std::string stamp_reported;
  if (absolute) {
    judge_absolute(at, first, options, format, stamp_reported);
  } else {
    judge_relative(at, options, format, stamp_reported);
  }
  return fmt::format("time: field '{}' {} {} {} (span {:.4f} s); {}", chosen.name,
                     type_name(chosen.type), unit.name, base_text(absolute, at), format.span_s,
                     stamp_reported);
}

void judge_span(const FirstClouds& first, const CloudField& field, CloudFormat& format) {
  const double period_s = first.stamp_period_s;
  if (period_s > 0.0 && (format.span_s > 1.3 * period_s || format.span_s < 0.1 * period_s)) {
    format.findings.push_back(cloud_finding(
        "D02", Severity::kWarning,
        fmt::format("the times of field '{}' span {:.4f} s, but the clouds come every {:.4f} s",
                    field.name, format.span_s, period_s),
        "motion within the scan may be undone by the wrong amount",
        "Set lidar.point_time, or none if the field holds something else."));
  } else if (format.span_s < kSpanUsualMinS || format.span_s > kSpanUsualMaxS) {
    format.findings.push_back(
        cloud_finding("D02", Severity::kWarning,
                      fmt::format("one scan spans {:.4f} s by field '{}'; usual are 0.02 to 0.2 s",
                                  format.span_s, field.name),
                      {}, {}));
  }
}

struct Fixed {
  const Unit* unit;
  bool absolute;
};

std::optional<Fixed> fixed_by(PointTime time) {
  switch (time) {
    case PointTime::kAbsoluteS:
      return Fixed{&kUnits[0], true};
    case PointTime::kAbsoluteNs:
      return Fixed{&kUnits[3], true};
    case PointTime::kRelativeS:
      return Fixed{&kUnits[0], false};
    case PointTime::kRelativeMs:
      return Fixed{&kUnits[1], false};
    case PointTime::kRelativeUs:
      return Fixed{&kUnits[2], false};
    case PointTime::kRelativeNs:
      return Fixed{&kUnits[3], false};
    default:
      return std::nullopt;
  }
}

}  // namespace

Finding cloud_finding(std::string id, Severity severity, std::string text, std::string effect,
                      std::string remedy) {
  Finding finding;
  finding.id = std::move(id);
  finding.severity = severity;
  finding.text = std::move(text);
  finding.effect = std::move(effect);
  finding.remedy = std::move(remedy);
  return finding;
}

Result<std::string> choose_time(const FirstClouds& first, const CloudFormatOptions& options,
                                CloudFormat& format) {
  format.point_time = PointTime::kNone;
  format.scan_period_s = first.stamp_period_s > 0.0 ? first.stamp_period_s : options.scan_period_s;
  if (options.deskewed) return std::string("time: not needed (clouds are deskewed)");
  if (options.point_time == PointTime::kNone) return std::string("time: none (set)");
  if (options.point_time == PointTime::kAzimuth) return std::string();
  const std::optional<Fixed> fixed = fixed_by(options.point_time);
  std::string why;
  for (const std::string_view name : kTimeNames) {
    const int field = find_field(*first.clouds[0].view, name);
    if (field < 0) continue;
    const CloudField& candidate = first.fields()[static_cast<std::size_t>(field)];
    const TimeValues times = read_times(first, field);
    std::string fault = unusable_because(times, candidate);
    const Unit* unit = nullptr;
    if (fault.empty() && fixed) {
      unit = fixed->unit;
      if (!(times.span * unit->scale_s <= kSpanSetMaxS)) {
        fault = fmt::format(
            "field '{}' spans {:.4g} s in a scan if it counts {}; usual are 0.02 "
            "to 0.2 s",
            candidate.name, times.span * unit->scale_s, unit->name);
      }
    }
    if (fault.empty() && unit == nullptr) unit = unit_for(times.span, first.stamp_period_s);
    if (fault.empty() && unit == nullptr) unit = unit_for(times.span, 0.0);
    if (fault.empty() && unit == nullptr) {
      fault = fmt::format("field '{}' spans {:.6g} in a scan, which is 0.02 to 0.2 s in no unit",
                          candidate.name, times.span);
    }
    if (!fault.empty()) {
      why += (why.empty() ? "" : "; ") + fault;
      continue;
    }
    const bool absolute = fixed ? fixed->absolute : is_absolute(times, unit->scale_s);
    std::string reported = accept(first, field, times, *unit, absolute, options, format);
    if (first.stamp_period_s <= 0.0) {
      format.scan_period_s = std::max(format.span_s, kSpanMinS);
    }
    judge_span(first, candidate, format);
    return reported;
  }
  if (fixed) {
    return fail(ErrorCode::kInput, "lidar.point_time",
                why.empty() ? "the clouds have no field for point times" : why,
                "Set it to auto, azimuth or none.");
  }
  if (!why.empty()) {
    format.findings.push_back(
        cloud_finding("D02", Severity::kWarning, why, "the field gives no point times", {}));
  }
  return std::string();
}

}  // namespace rali::wire::internal
