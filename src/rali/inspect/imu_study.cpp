#include "rali/inspect/imu_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/imu/rest.hpp"
#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kGravity = 9.81;
/// Second differences of white noise have sqrt(6) times its spread, and take out slow motion.
constexpr double kSecondDifference = 2.449489742783178;

/// Spread of the fast part of one quantity, per axis, largest axis.
template <class Get>
double fast_spread(std::span<const sensor::ImuSample> samples, Get get) {
  geometry::Vec3 sum = geometry::Vec3::Zero();
  for (std::size_t i = 2; i < samples.size(); ++i) {
    const geometry::Vec3 d = get(samples[i]) - 2.0 * get(samples[i - 1]) + get(samples[i - 2]);
    sum += d.cwiseProduct(d);
  }
  const double n = std::max(1.0, static_cast<double>(samples.size()) - 2.0);
  return std::sqrt((sum / n).maxCoeff()) / kSecondDifference;
}

double accel_spread(std::span<const sensor::ImuSample> samples) {
  return fast_spread(samples, [](const sensor::ImuSample& s) { return s.accel_mps2; });
}

double gyro_spread(std::span<const sensor::ImuSample> samples) {
  return fast_spread(samples, [](const sensor::ImuSample& s) { return s.gyro_radps; });
}

std::span<const sensor::ImuSample> between(std::span<const sensor::ImuSample> samples, Time begin,
                                           Time end) {
  const auto older = [](const sensor::ImuSample& s, Time t) { return s.t < t; };
  const auto first = std::lower_bound(samples.begin(), samples.end(), begin, older);
  const auto last = std::lower_bound(first, samples.end(), end, older);
  return {first, last};
}

/// Values that stand at the largest value ever seen, several times in a row: a sensor at its end.
std::uint64_t count_saturated(std::span<const sensor::ImuSample> samples) {
  std::uint64_t saturated = 0;
  for (int axis = 0; axis < 6; ++axis) {
    const auto value = [axis](const sensor::ImuSample& s) {
      return std::abs(axis < 3 ? s.gyro_radps(axis) : s.accel_mps2(axis - 3));
    };
    double most = 0.0;
    for (const sensor::ImuSample& s : samples) most = std::max(most, value(s));
    std::uint64_t run = 0;
    for (const sensor::ImuSample& s : samples) {
      run = most > 0.0 && value(s) == most ? run + 1 : 0;
      if (run >= 3) saturated += run == 3 ? 3 : 1;
    }
  }
  return saturated == 3 * samples.size() ? 0 : saturated;
}

std::vector<sensor::ImuSample> valid_si(std::span<const sensor::ImuSample> raw,
                                        const ImuStudy& study) {
  std::vector<sensor::ImuSample> out;
  out.reserve(raw.size());
  for (sensor::ImuSample s : raw) {
    if (!s.gyro_radps.allFinite() || !s.accel_mps2.allFinite()) continue;
    s.gyro_radps *= study.gyro_scale;
    s.accel_mps2 *= study.accel_scale;
    out.push_back(s);
  }
  return out;
}

void study_units(std::span<const sensor::ImuSample> valid, std::optional<double> gyro_scale,
                 const std::string& topic, ImuStudy& study, FindingList& out) {
  drive::InputOptions options;
  if (gyro_scale) options.gyro_unit = drive::GyroUnit::kRadps;  // already known better
  const auto units = drive::decide_imu_units(valid, options, topic);
  if (!units) {
    study.units_known = false;
    out.push_back(make_finding(
        "D08", Severity::kError, topic,
        {units.error().what, "nothing tells which way is up",
         units.error().remedy.empty() ? "Record the raw accelerometer." : units.error().remedy},
        {drive::quietest_stretch(valid).accel_norm_median, kGravity}));
    return;
  }
  study.accel_scale = units->accel_scale;
  study.gyro_scale = gyro_scale.value_or(units->gyro_scale);
  for (Finding finding : units->findings) {
    finding.topic = topic;
    out.push_back(std::move(finding));
  }
}

void report_noise(const ImuStudy& study, const std::string& topic, FindingList& out) {
  const bool loud = study.gyro_noise_radps_rthz > 0.01 || study.accel_noise_mps2_rthz > 0.1;
  out.push_back(make_finding(
      "D10", loud ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("noise at rest {:.2g} rad/s/rtHz and {:.2g} m/s^2/rtHz",
                   study.gyro_noise_radps_rthz, study.accel_noise_mps2_rthz),
       loud ? "poses between sweeps are poor" : "",
       loud ? "Mount the IMU on a stiff, damped base; check its filter settings." : ""},
      {study.gyro_noise_radps_rthz, 0.01}));
}

void study_noise(std::span<const sensor::ImuSample> si, double period_s, const std::string& topic,
                 ImuStudy& study, FindingList& out) {
  const drive::ImuStretch quiet = drive::quietest_stretch(si);
  const geometry::Vec3& up = quiet.accel_mean;
  if (up.norm() > 0.5 * kGravity) study.up_imu = up.normalized();
  study.up_sigma_rad = quiet.at_rest ? 0.01 : 0.1;
  if (!quiet.at_rest || period_s <= 0.0) return;
  const auto rest = between(si, quiet.t_begin, quiet.t_end);
  if (rest.size() < 10) return;
  const double root_period = std::sqrt(period_s);
  study.gyro_noise_radps_rthz = gyro_spread(rest) * root_period;
  study.accel_noise_mps2_rthz = accel_spread(rest) * root_period;
  report_noise(study, topic, out);
  const double at_rest = accel_spread(rest), overall = accel_spread(si);
  if (!(at_rest > 0.0)) return;
  study.vibration_factor = overall / at_rest;
  const bool shaken = study.vibration_factor > 20.0;
  out.push_back(
      make_finding("D10", shaken ? Severity::kWarning : Severity::kInfo, topic,
                   {fmt::format("driving shakes the IMU {:.1f} times as much as its noise at rest",
                                study.vibration_factor),
                    shaken ? "the inertial data are worth less than the data sheet says" : "",
                    shaken ? fmt::format("Set imu.vibration_factor: {:.0f}, or damp the mount.",
                                         study.vibration_factor)
                           : ""},
                   {study.vibration_factor, 20.0}));
}

void study_start(std::span<const sensor::ImuSample> si, const std::string& topic, ImuStudy& study,
                 FindingList& out) {
  const auto first = between(si, si.front().t, si.front().t + Duration::from_s(1.0));
  const imu::ImuStatistics stats = imu::statistics(first);
  study.rest_at_start = imu::is_rest(stats, imu::RestSettings{});
  if (!study.rest_at_start) {
    out.push_back(make_finding("D13", Severity::kWarning, topic,
                               {"no standstill at the start: the recording begins in motion",
                                "gravity and gyro bias are found while driving, less exactly",
                                "Stand still for two seconds before driving off."},
                               {stats.gyro_sd_radps.maxCoeff(), 0.02}));
    return;
  }
  const geometry::Vec3 up = stats.accel_mean_mps2.normalized();
  const double tilt_deg = std::acos(std::clamp(up.z(), -1.0, 1.0)) * kDegPerRad;
  out.push_back(make_finding(
      "D13", tilt_deg > 30.0 ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("standstill at the start; the IMU's z axis is {:.1f} deg off the vertical",
                   tilt_deg),
       tilt_deg > 30.0 ? "the body's z is not up: directions in the report are those of the IMU"
                       : "",
       tilt_deg > 30.0 ? "Give imu.T_body_imu." : ""},
      {tilt_deg, 30.0}));
}

void report_counts(const ImuStudy& study, std::size_t samples, const std::string& topic,
                   FindingList& out) {
  const auto share = [samples](std::uint64_t n) {
    return static_cast<double>(n) / std::max(1.0, static_cast<double>(samples));
  };
  if (study.invalid > 0) {
    out.push_back(make_finding(
        "D10", share(study.invalid) > 0.2 ? Severity::kError : Severity::kWarning, topic,
        {fmt::format("{} without numbers ({:.2g} %)", counted(study.invalid, "sample"),
                     100.0 * share(study.invalid)),
         "they are left out", "Check the IMU's driver."},
        {share(study.invalid), 0.2}));
  }
  if (study.saturated == 0) return;
  out.push_back(make_finding(
      "D10", share(study.saturated) > 0.01 ? Severity::kError : Severity::kWarning, topic,
      {fmt::format("{} values stand at the end of the sensor's range", study.saturated),
       "turns and shocks are cut off and the pose jumps there",
       "Set a larger range of the IMU, or damp its mount."},
      {share(study.saturated), 0.01}));
}

}  // namespace

ImuStudy study_imu(std::span<const sensor::ImuSample> raw, double period_s,
                   std::optional<double> gyro_scale, const std::string& topic, FindingList& out) {
  ImuStudy study;
  const std::vector<sensor::ImuSample> valid = valid_si(raw, study);
  study.invalid = raw.size() - valid.size();
  study.saturated = count_saturated(valid);
  report_counts(study, raw.size(), topic, out);
  if (valid.size() < 10) return study;
  study_units(valid, gyro_scale, topic, study, out);
  if (!study.units_known) return study;
  const std::vector<sensor::ImuSample> si = valid_si(valid, study);
  study_noise(si, period_s, topic, study, out);
  study_start(si, topic, study, out);
  return study;
}

}  // namespace rali::inspect
