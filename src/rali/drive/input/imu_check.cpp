#include "rali/drive/input/imu_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace rali::drive {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kStretchS = 0.5;
/// A gyro at rest shows its bias: cheap parts are specified to 3 deg/s = 0.05 rad/s, so 0.1 in
/// "rad/s" is no bias. It may be a steady turn on a smooth floor, though, with as little noise.
/// Only beyond 2 rad/s the accelerometer always senses a vehicle's turn.
constexpr double kRestGyroMean = 0.1;
constexpr double kSteadyTurnMax = 2.0;
/// Noise from sample to sample, unaffected by turns: 0.05 in "rad/s" is a number of degrees.
constexpr double kRestGyroNoise = 0.05;
/// Means over 0.1 s at rest differ by their remaining white noise, and otherwise by no more than
/// this. A vehicle that starts a turn within the half second differs by more.
constexpr double kBlockS = 0.1;
constexpr double kRestGyroBlocks = 0.03;
/// Spread of |a| at rest: 1 % is ten times the noise of the worst data sheet at 200 Hz.
constexpr double kRestAccelFraction = 0.015;
/// No cart or car turns at 6 rad/s for half of an interval; in deg/s that is a slow turn.
constexpr double kDrivingGyroMedian = 6.0;

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Largest spread of the three axes from sample to sample: white noise without rotation.
double gyro_noise(std::span<const sensor::ImuSample> samples) {
  if (samples.size() < 2) return 0.0;
  geometry::Vec3 sum = geometry::Vec3::Zero();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    sum += (samples[i].gyro_radps - samples[i - 1].gyro_radps).cwiseAbs2();
  }
  return std::sqrt(sum.maxCoeff() / (2.0 * static_cast<double>(samples.size() - 1)));
}

/// Whether the gyro's means over kBlockS agree as they do without motion.
bool gyro_is_steady(std::span<const sensor::ImuSample> samples, double noise) {
  const double span_s = std::abs(seconds_between(samples.front().t, samples.back().t));
  const auto blocks = static_cast<std::size_t>(std::clamp(span_s / kBlockS, 2.0, 1e4));
  const std::size_t length = samples.size() / blocks;
  if (length == 0) return false;
  geometry::Vec3 sum = geometry::Vec3::Zero(), sum_of_squares = geometry::Vec3::Zero();
  for (std::size_t b = 0; b < blocks; ++b) {
    geometry::Vec3 mean = geometry::Vec3::Zero();
    for (const sensor::ImuSample& i : samples.subspan(b * length, length)) {
      mean += i.gyro_radps / static_cast<double>(length);
    }
    // Relative to the first sample, so that squares of a large bias do not cost digits.
    mean -= samples.front().gyro_radps;
    sum += mean;
    sum_of_squares += mean.cwiseAbs2();
  }
  const auto n = static_cast<double>(blocks);
  const geometry::Vec3 variance = sum_of_squares / n - (sum / n).cwiseAbs2();
  const double left_by_noise = 3.0 * noise / std::sqrt(static_cast<double>(length));
  return std::sqrt(std::max(variance.maxCoeff(), 0.0)) < std::max(kRestGyroBlocks, left_by_noise);
}

ImuStretch describe(std::span<const sensor::ImuSample> samples) {
  ImuStretch s;
  if (samples.empty()) return s;
  const auto n = static_cast<double>(samples.size());
  std::vector<double> norms;
  norms.reserve(samples.size());
  for (const sensor::ImuSample& i : samples) {
    s.accel_mean += i.accel_mps2 / n;
    s.gyro_mean += i.gyro_radps / n;
    norms.push_back(i.accel_mps2.norm());
  }
  double accel_var = 0.0;
  for (const sensor::ImuSample& i : samples) {
    accel_var += (i.accel_mps2 - s.accel_mean).squaredNorm() / (3.0 * n);
  }
  s.accel_norm_median = median(norms);
  s.gyro_noise = gyro_noise(samples);
  s.accel_std_fraction =
      s.accel_norm_median > 0.0 ? std::sqrt(accel_var) / s.accel_norm_median : 0.0;
  s.t_start = samples.front().t;
  s.t_end = samples.back().t;
  s.at_rest = samples.size() >= 10 && s.accel_std_fraction < kRestAccelFraction &&
              gyro_is_steady(samples, s.gyro_noise);
  return s;
}

/// Standstill before motion, then the lower accelerometer noise.
bool quieter(const ImuStretch& a, const ImuStretch& b) {
  if (a.at_rest != b.at_rest) return a.at_rest;
  return a.accel_std_fraction < b.accel_std_fraction;
}

Finding finding(const char* id, Severity severity, const std::string& topic, std::string text,
                double value, double limit) {
  Finding f;
  f.id = id;
  f.severity = severity;
  f.topic = topic;
  f.text = std::move(text);
  f.value = value;
  f.limit = limit;
  return f;
}

Result<double> accel_scale(const ImuStretch& stretch, AccelUnit unit, const std::string& topic,
                           FindingList& findings) {
  if (unit == AccelUnit::kMps2) return 1.0;
  if (unit == AccelUnit::kG) return kGravity;
  const double a = stretch.accel_norm_median;
  const std::string when = stretch.at_rest ? "at rest" : "while moving";
  if (a > 7.0 && a < 13.0) return 1.0;
  if (a > 0.7 && a < 1.4) {
    // The manufacturer's g is not documented (Livox-SDK#107): at rest the measured norm is the
    // unit.
    const double scale = stretch.at_rest ? kGravity / a : kGravity;
    findings.push_back(finding(
        "D08", Severity::kWarning, topic,
        fmt::format("the accelerometer measures {:.3f} {}: its unit is g, multiplied by {:.4f}", a,
                    when, scale),
        a, 1.4));
    return scale;
  }
  if (a < 0.5) {
    return fail(ErrorCode::kInput, topic,
                fmt::format("the accelerometer measures {:.2f} {}: gravity was removed from the "
                            "data, so that nothing can be levelled",
                            a, when),
                "Record the raw acceleration, or use imu.topic: none.");
  }
  findings.push_back(finding(
      "D08", Severity::kWarning, topic,
      fmt::format("the accelerometer measures {:.2f} {}, neither 9.8 (m/s^2) nor 1 (g); taken as "
                  "m/s^2",
                  a, when),
      a, 13.0));
  return 1.0;
}

/// At rest the noise or rate is impossible in rad/s.
bool counts_degrees_at_rest(const ImuStretch& rest) {
  return rest.at_rest &&
         (rest.gyro_noise > kRestGyroNoise || rest.gyro_mean.norm() > kSteadyTurnMax);
}

double median_rate(std::span<const sensor::ImuSample> samples) {
  std::vector<double> rates;
  rates.reserve(samples.size());
  for (const sensor::ImuSample& s : samples) rates.push_back(s.gyro_radps.norm());
  return median(rates);
}

double gyro_scale(std::span<const sensor::ImuSample> first, const ImuStretch& rest, GyroUnit unit,
                  const std::string& topic, FindingList& findings) {
  constexpr double kDeg = std::numbers::pi / 180.0;
  if (unit == GyroUnit::kRadps) return 1.0;
  if (unit == GyroUnit::kDegps) return kDeg;
  const double mean = rest.gyro_mean.norm();
  if (counts_degrees_at_rest(rest)) {
    findings.push_back(
        finding("D09", Severity::kWarning, topic,
                fmt::format("the gyro shows {:.3f} +- {:.3f} at rest: its unit is deg/s", mean,
                            rest.gyro_noise),
                mean, kRestGyroMean));
    return kDeg;
  }
  const double rate = median_rate(first);
  const double span_s = seconds_between(first.front().t, first.back().t);
  if (rate > kDrivingGyroMedian) {
    findings.push_back(finding("D09", Severity::kWarning, topic,
                               fmt::format("the gyro shows {:.1f} for most of the first {:.1f} s, "
                                           "which no vehicle turns in rad/s: its unit is deg/s",
                                           rate, span_s),
                               rate, kDrivingGyroMedian));
    return kDeg;
  }
  if (rest.at_rest && mean > kRestGyroMean && gyro_is_steady(first, rest.gyro_noise)) {
    // A bias in deg/s and a steady turn look alike; a factor of 57 is not applied on a guess.
    findings.push_back(finding("D09", Severity::kWarning, topic,
                               fmt::format("the gyro shows a steady {:.3f} for the first {:.1f} s: "
                                           "a bend in rad/s, or a bias in deg/s; taken as rad/s",
                                           mean, span_s),
                               mean, kRestGyroMean));
    findings.back().remedy = "If the vehicle stood still, set imu.gyro_unit: deg_s.";
  }
  return 1.0;
}

}  // namespace

ImuStretch quietest_stretch(std::span<const sensor::ImuSample> samples) {
  if (samples.empty()) return {};
  ImuStretch best;
  bool found = false;
  std::size_t begin = 0;
  while (begin < samples.size()) {
    std::size_t end = begin + 1;
    while (end < samples.size() &&
           std::abs(seconds_between(samples[begin].t, samples[end].t)) < kStretchS) {
      ++end;
    }
    const ImuStretch s = describe(samples.subspan(begin, end - begin));
    const bool whole = end < samples.size() || !found;
    if (whole && (!found || quieter(s, best))) {
      best = s;
      found = true;
    }
    begin = end;
  }
  return best;
}

Result<ImuUnits> decide_imu_units(std::span<const sensor::ImuSample> first,
                                  const InputOptions& options, const std::string& topic) {
  ImuUnits units;
  if (first.empty()) return units;
  const ImuStretch rest = quietest_stretch(first);
  const Result<double> accel = accel_scale(rest, options.accel_unit, topic, units.findings);
  if (!accel) return tl::make_unexpected(accel.error());
  units.accel_scale = *accel;
  units.gyro_scale = gyro_scale(first, rest, options.gyro_unit, topic, units.findings);
  for (Finding& f : units.findings) f.vehicle = options.vehicle;
  return units;
}

double GyroRatio::ratio() const { return lidar_rad_ > 0.2 ? gyro_rad_ / lidar_rad_ : 0.0; }

}  // namespace rali::drive
