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
#include "rali/odometry/robust/stillness.hpp"

namespace rali::inspect {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kGravity = 9.81;
/// Over two seconds the mean specific force is close to gravity despite vibration, turns and
/// braking: braking with 2.5 m/s^2 adds 3.2 %.
constexpr double kStretch_s = 2.0;
constexpr double kGravityFraction = 0.035;
/// A larger factor is a wrong unit (decide_imu_units), not a scale error.
constexpr double kUnitFraction = 0.28;
/// Second differences of white noise have sqrt(6) times its spread, and remove slow motion.
constexpr double kSecondDifference = 2.449489742783178;

/// Spread of the high-frequency part of one quantity, per axis, largest axis.
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

double axis_of(const sensor::ImuSample& s, int axis) {
  return std::abs(axis < 3 ? s.gyro_radps(axis) : s.accel_mps2(axis - 3));
}

/// Counts saturated samples of one axis: three or more in a row exactly at the largest value of
/// their window. If other values repeat as well, the cause is the converter's resolution.
std::uint64_t stuck_at_end(std::span<const sensor::ImuSample> samples, int axis) {
  double maximum = 0.0;
  for (const sensor::ImuSample& s : samples) maximum = std::max(maximum, axis_of(s, axis));
  if (!(maximum > 0.0)) return 0;
  std::uint64_t stuck = 0, run = 0, pairs = 0, alike = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double value = axis_of(samples[i], axis);
    run = value == maximum ? run + 1 : 0;
    if (run >= 3) stuck += run == 3 ? 3 : 1;
    if (i == 0 || value == maximum) continue;
    ++pairs;
    if (value == axis_of(samples[i - 1], axis)) ++alike;
  }
  return alike * 5 > pairs ? 0 : stuck;
}

/// By windows: a range that is too small shows during hard driving, not in the overall maximum.
std::uint64_t count_saturated(std::span<const sensor::ImuSample> samples) {
  std::uint64_t saturated = 0;
  for (std::size_t begin = 0; begin < samples.size();) {
    std::size_t end = begin + 1;
    const Time t_end = samples[begin].t + Duration::from_s(kStretch_s);
    while (end < samples.size() && samples[end].t < t_end) ++end;
    const auto stretch = samples.subspan(begin, end - begin);
    for (int axis = 0; axis < 6; ++axis) saturated += stuck_at_end(stretch, axis);
    begin = end;
  }
  return saturated >= 3 * samples.size() ? 0 : saturated;
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
  if (gyro_scale) options.gyro_unit = drive::GyroUnit::kRadps;  // more accurate than by value
  const auto units = drive::decide_imu_units(valid, options, topic);
  if (!units) {
    study.units_known = false;
    out.push_back(make_finding(
        "D08", Severity::kError, topic,
        {units.error().what, "the direction of gravity is not known",
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
       loud ? "poses between scans are poor" : "",
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
  const auto rest = between(si, quiet.t_start, quiet.t_end);
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
                    shaken ? "the inertial data are noisier than the data sheet states" : "",
                    shaken ? fmt::format("Set imu.vibration_factor: {:.0f}, or damp the mount.",
                                         study.vibration_factor)
                           : ""},
                   {study.vibration_factor, 20.0}));
}

/// Gravity over the whole recording: detects a wrong or a varying scale. Curves and changes of
/// speed make the force longer, but not its part along the vertical; slopes change the part, but
/// not the length.
void study_gravity(std::span<const sensor::ImuSample> si, const geometry::Vec3& up_imu,
                   const std::string& topic, FindingList& out) {
  const Duration step = Duration::from_s(0.5 * kStretch_s);
  double worst = 0.0;
  Time first, last;
  bool any = false;
  for (Time t = si.front().t; t + step + step <= si.back().t; t = t + step) {
    const auto stretch = between(si, t, t + step + step);
    if (stretch.size() < 10) continue;
    const geometry::Vec3 mean_mps2 = imu::statistics(stretch).accel_mean_mps2;
    const double length = mean_mps2.norm() / kGravity - 1.0;
    const double upward = mean_mps2.dot(up_imu) / kGravity - 1.0;
    const double fraction = std::abs(length) < std::abs(upward) ? length : upward;
    if (std::abs(fraction) <= kGravityFraction || std::abs(fraction) > kUnitFraction) continue;
    if (!any) first = t;
    last = t + step + step;
    any = true;
    if (std::abs(fraction) > std::abs(worst)) worst = fraction;
  }
  if (!any) return;
  out.push_back(make_finding(
      "D08", Severity::kWarning, topic,
      {fmt::format("the accelerometer measures {:.2f} m/s^2, {:+.1f} % off gravity, between {:.1f} "
                   "and {:.1f} s: its scale is off, or it rode in a lift",
                   (1.0 + worst) * kGravity, 100.0 * worst, seconds_between(si.front().t, first),
                   seconds_between(si.front().t, last)),
       "speed and slope come out wrong, the gyro may be off as much",
       "Calibrate the IMU; check its range setting and supply."},
      {worst, kGravityFraction}));
}

void study_start(std::span<const sensor::ImuSample> si, const geometry::Mat3& R_body_imu,
                 const std::string& topic, ImuStudy& study, FindingList& out) {
  const auto first = between(si, si.front().t, si.front().t + Duration::from_s(1.0));
  // Over blocks, as the odometry's standstill detector: white noise alone exceeds slow driving.
  const imu::RestSettings settings;
  const imu::ImuStatistics stats =
      imu::statistics(odometry::block_means({first.begin(), first.end()}));
  study.rest_at_start = stats.samples > 1 && odometry::is_quiet(stats, settings) &&
                        stats.gyro_mean_radps.norm() < settings.gyro_mean_max_radps;
  if (!study.rest_at_start) {
    out.push_back(make_finding("D13", Severity::kWarning, topic,
                               {"no standstill at the start: the recording starts in motion",
                                "gravity and gyro bias are estimated while driving, less exactly",
                                "Stand still for two seconds before driving off."},
                               {stats.gyro_sd_radps.maxCoeff(), 0.02}));
    return;
  }
  const geometry::Vec3 up = R_body_imu * stats.accel_mean_mps2.normalized();
  const bool turned = !R_body_imu.isIdentity(1e-3);
  const double tilt_deg = std::acos(std::clamp(up.z(), -1.0, 1.0)) * kDegPerRad;
  out.push_back(make_finding(
      "D13", tilt_deg > 30.0 ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("standstill at the start; the {} z axis is {:.1f} deg off the vertical",
                   turned ? "body's" : "IMU's", tilt_deg),
       tilt_deg > 30.0 ? "the body's z is not up: directions in the report are those of the IMU"
                       : "",
       tilt_deg > 30.0 ? (turned ? "Check imu.T_body_imu." : "Give imu.T_body_imu.") : ""},
      {tilt_deg, 30.0}));
}

void report_counts(const ImuStudy& study, std::size_t samples, const std::string& topic,
                   FindingList& out) {
  const auto fraction = [samples](std::uint64_t n) {
    return static_cast<double>(n) / std::max(1.0, static_cast<double>(samples));
  };
  if (study.invalid > 0) {
    out.push_back(make_finding(
        "D10", fraction(study.invalid) > 0.2 ? Severity::kError : Severity::kWarning, topic,
        {fmt::format("{} without numbers ({})", counted(study.invalid, "sample"),
                     percent(fraction(study.invalid))),
         "they are left out", "Check the IMU's driver."},
        {fraction(study.invalid), 0.2}));
  }
  if (study.saturated == 0) return;
  out.push_back(make_finding(
      "D10", fraction(study.saturated) > 0.01 ? Severity::kError : Severity::kWarning, topic,
      {fmt::format("{} values are at the end of the sensor's range", study.saturated),
       "turns and shocks are cut off and the pose jumps there",
       "Set a larger range of the IMU, or damp its mount."},
      {fraction(study.saturated), 0.01}));
}

}  // namespace

ImuStudy study_imu(std::span<const sensor::ImuSample> raw, double period_s,
                   std::optional<double> gyro_scale, const std::string& topic, FindingList& out,
                   const geometry::Mat3& R_body_imu) {
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
  study_start(si, R_body_imu, topic, study, out);
  study_gravity(si, study.up_imu, topic, out);
  return study;
}

}  // namespace rali::inspect
