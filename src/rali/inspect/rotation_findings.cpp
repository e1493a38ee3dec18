#include "rali/inspect/rotation_findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/imu/mounting.hpp"
#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kOffsetMin_s = 0.005;
/// Above this rotation during the LiDAR-IMU time offset walls double visibly: 0.5 deg is 9 cm at 10
/// m.
constexpr double kSmearMax_rad = 0.5 / kDegPerRad;
constexpr double kMisfitMax = 0.15;  ///< about 9 degrees
/// At slower rotation the noise of LiDAR poses dominates.
constexpr double kTurnRateSeen_radps = 0.1;
constexpr double kSecondAxisMin = 0.1;
constexpr double kDegenerateMax = 0.2;  ///< of the scans
constexpr double kUnitFactor = 2.0;     ///< more is no scale error
constexpr double kTiltMax_rad = 8.0 / kDegPerRad;
constexpr double kVaultMax_rad = 40.0 / kDegPerRad;  ///< of a plane above: a vault's side
constexpr double kAlike_rad = 5.0 / kDegPerRad;

double angle_between(const geometry::Vec3& a, const geometry::Vec3& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

/// The 24 permutations of the axes of a right-handed frame.
std::vector<geometry::Mat3> axis_swaps() {
  std::vector<geometry::Mat3> swaps;
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  for (const auto& order : kOrders) {
    for (int signs = 0; signs < 8; ++signs) {
      geometry::Mat3 R = geometry::Mat3::Zero();
      for (int k = 0; k < 3; ++k) {
        R(k, order[static_cast<std::size_t>(k)]) = (signs >> k) % 2 == 0 ? 1.0 : -1.0;
      }
      const double determinant = R.row(0).cross(R.row(1)).dot(R.row(2));
      if (determinant > 0.0) swaps.push_back(R);
    }
  }
  return swaps;
}

std::string rpy_text(const geometry::Mat3& R) {
  const geometry::Vec3 rpy = geometry::rpy_from_rotation(R) * kDegPerRad;
  return fmt::format("[{:.1f}, {:.1f}, {:.1f}]", rpy.x(), rpy.y(), rpy.z());
}

void report_not_seen(const std::string& id, const imu::RotationStudy& study,
                     const std::string& what, FindingList& out) {
  out.push_back(
      make_finding(id, Severity::kInfo, "",
                   {fmt::format("{} not observable: the vehicle turned {:.1f} deg in all", what,
                                study.turned_rad * kDegPerRad),
                    "", "Turn the vehicle left and right a few times at the start of a recording."},
                   {study.turned_rad, 0.5}));
}

/// How the given rotation became the wrong one, if it shows: a common mistake fits about as well as
/// the best rotation. The inverse first: it is more likely than an equivalent swap of axes.
std::string likely_mistake(const geometry::Mat3& R_given, const imu::MountingByTurning& judged,
                           std::span<const imu::LidarTurn> lidar,
                           std::span<const sensor::ImuSample> imu,
                           const imu::RotationStudy& study) {
  const auto fits = [&](const geometry::Mat3& R) {
    return imu::misfit_of(R, lidar, imu, study) < judged.misfit_rad + kAlike_rad;
  };
  if (fits(R_given.transpose())) return "its inverse";
  for (const geometry::Mat3& swap : axis_swaps()) {
    if (fits(R_given * swap)) return "swapped axes";
  }
  return "the rotation estimated from the data";
}

}  // namespace

void report_gyro_unit(const imu::RotationStudy& study, double degenerate_fraction,
                      const std::string& topic, FindingList& out) {
  if (study.gyro_ratio == 0.0) return report_not_seen("D09", study, "the gyro's unit is", out);
  const double ratio = study.gyro_ratio;
  const double limit = degenerate_fraction > kDegenerateMax ? kUnitFactor : 1.1;
  if (ratio < limit && study.gyro_ratio_max > 1.0 / limit) {
    out.push_back(make_finding(
        "D09", Severity::kInfo, topic,
        {fmt::format("gyro and LiDAR turn alike, ratio {:.3f}", ratio), "", ""}, {ratio, 1.0}));
    return;
  }
  const bool degrees = std::abs(ratio / kDegPerRad - 1.0) < 0.15;
  out.push_back(
      make_finding("D09", Severity::kError, topic,
                   {fmt::format("the gyro turns {:.3g} times as much as the LiDAR{}", ratio,
                                degrees ? ": its unit is deg/s" : ""),
                    "every turn is mapped wrongly",
                    degrees ? "Set imu.gyro_unit: deg_s." : "Check the gyro's range and scale."},
                   {ratio, 1.0}));
}

void report_time_offset(const imu::RotationStudy& study, const std::string& topic,
                        FindingList& out) {
  if (!study.time_offset_s) {
    // Both have turned: the LiDAR's rate alone may be noise.
    const bool turned = std::min(study.turn_rate_rms, study.gyro_rate_rms) > kTurnRateSeen_radps;
    if (!study.offset_at_border || !turned)
      return report_not_seen("D12", study, "the time offset is", out);
    out.push_back(make_finding("D12", Severity::kWarning, topic,
                               {"no time offset within 0.3 s makes LiDAR and gyro turn alike",
                                "the clocks may differ by more", "Compare the clocks (D04)."}));
    return;
  }
  const double offset_s = *study.time_offset_s;
  const double limit_s = std::max(kOffsetMin_s, 3.0 * study.time_offset_sigma_s);
  const double smear_rad = std::abs(offset_s) * study.turn_rate_rms;
  const bool real = std::abs(offset_s) > limit_s;
  const bool serious = real && (smear_rad > kSmearMax_rad || std::abs(offset_s) > 0.02);
  out.push_back(make_finding(
      "D12",
      serious ? Severity::kError
      : real  ? Severity::kWarning
              : Severity::kInfo,
      topic,
      {fmt::format("time offset LiDAR to IMU {:+.1f} ms, sigma {:.1f} ms", 1e3 * offset_s,
                   1e3 * study.time_offset_sigma_s),
       real ? fmt::format("walls are off by {:.2f} m at 10 m when turning as in this recording",
                          10.0 * smear_rad)
            : "",
       real ? fmt::format("Set lidar.time_offset_s: {:.4f}, or synchronise the clocks.", offset_s)
            : ""},
      {offset_s, limit_s}));
}

void report_extrinsics(const imu::RotationStudy& study, const ExtrinsicsGiven& given,
                       std::span<const imu::LidarTurn> lidar,
                       std::span<const sensor::ImuSample> imu, FindingList& out) {
  if (study.gyro_ratio == 0.0) {
    return report_not_seen("D11", study, "the LiDAR's rotation in the body is", out);
  }
  const geometry::Mat3 R_given =
      given.R_body_imu.transpose() * given.R_body_lidar.value_or(geometry::Mat3::Identity());
  const imu::MountingByTurning judged = imu::judge_mounting(R_given, lidar, imu, study);
  const std::string which =
      given.R_body_lidar ? "T_body_lidar (" + given.origin + ")" : "the identity as T_body_lidar";
  const double given_deg = judged.assumed_misfit_rad * kDegPerRad;
  Finding f;
  switch (judged.verdict) {
    case imu::MountingVerdict::kUndecided:
      f = make_finding(
          "D11", Severity::kInfo, "",
          {fmt::format(
               "the turning does not decide whether {} is right: it fits to {:.1f} deg, the "
               "best rotation to {:.1f}",
               which, given_deg, judged.misfit_rad * kDegPerRad),
           "", "Turn the vehicle left and right a few times at the start of a recording."});
      break;
    case imu::MountingVerdict::kAgrees:
      f = make_finding(
          "D11", Severity::kInfo, "",
          {fmt::format("{} fits the turning to {:.1f} deg{}", which, given_deg,
                       study.second_axis_fraction < kSecondAxisMin
                           ? "; the angle about the axis it turned about is not observable"
                           : ""),
           "", ""});
      break;
    case imu::MountingVerdict::kContradicts:
      f = make_finding("D11", given.R_body_lidar ? Severity::kError : Severity::kWarning, "",
                       {fmt::format("{} does not fit, {} does: {:.1f} against {:.1f} deg", which,
                                    likely_mistake(R_given, judged, lidar, imu, study),
                                    judged.misfit_rad * kDegPerRad, given_deg),
                        "the map falls apart at the first turn",
                        fmt::format("Set lidar.T_body_lidar rpy_deg: {}.",
                                    rpy_text(given.R_body_imu * judged.R_imu_lidar))});
      break;
  }
  f.value = given_deg;
  f.limit = judged.misfit_rad * kDegPerRad;
  out.push_back(std::move(f));
}

void report_up(const std::optional<geometry::Vec3>& up_lidar, const geometry::Vec3& up_imu,
               const imu::RotationStudy& study, const ExtrinsicsGiven& given,
               const std::string& topic, FindingList& out) {
  if (!up_lidar) {
    out.push_back(
        make_finding("D07", Severity::kInfo, topic,
                     {"no ground seen near the vehicle: axes not compared with gravity", "", ""}));
    return;
  }
  const geometry::Mat3 R_imu_lidar =
      given.R_body_imu.transpose() * given.R_body_lidar.value_or(geometry::Mat3::Identity());
  const double tilt_rad = angle_between(R_imu_lidar * *up_lidar, up_imu);
  if (study.gyro_ratio != 0.0 && study.second_axis_fraction >= kSecondAxisMin &&
      study.best.misfit < kMisfitMax) {
    const geometry::Vec3 by_turning = study.best.R_imu_lidar * *up_lidar;
    if (std::numbers::pi - angle_between(by_turning, up_imu) < 4.0 * kAlike_rad &&
        tilt_rad < 4.0 * kTiltMax_rad) {
      out.push_back(make_finding("D07", Severity::kError, topic,
                                 {"the LiDAR turns left where the IMU turns right while both have "
                                  "the ground below: one of "
                                  "them has mirrored (left-handed) axes",
                                  "every turn is mapped the wrong way round",
                                  "Correct the driver's axes: x forward, y left, z up."},
                                 {-1.0, 1.0}));
      return;
    }
  }
  // The rotation distinguishes a ceiling above the LiDAR from a floor below an upside-down one.
  const bool hangs = study.gyro_ratio != 0.0 && (study.best.R_imu_lidar * *up_lidar).dot(up_imu) >
                                                    std::cos(4.0 * kTiltMax_rad);
  if (std::numbers::pi - tilt_rad < kVaultMax_rad && !hangs) {
    out.push_back(make_finding(
        "D07", Severity::kInfo, topic,
        {"the plane nearest to level lies above the LiDAR: a ceiling or vault, or the LiDAR hangs "
         "upside down, which T_body_lidar does not include",
         "", ""},
        {tilt_rad * kDegPerRad, kTiltMax_rad * kDegPerRad}));
    return;
  }
  // Turning shows where the vertical is, whatever plane the LiDAR sees: a dome that looks ahead or
  // a pipe shows no ground.
  const bool turning_agrees =
      study.gyro_ratio != 0.0 && angle_between(study.best.R_imu_lidar.transpose() * up_imu,
                                               R_imu_lidar.transpose() * up_imu) < kTiltMax_rad;
  if (tilt_rad > kTiltMax_rad && turning_agrees) {
    out.push_back(make_finding(
        "D07", Severity::kInfo, topic,
        {"the plane nearest to level is no ground: the turning agrees with T_body_lidar", "", ""},
        {tilt_rad * kDegPerRad, kTiltMax_rad * kDegPerRad}));
    return;
  }
  const bool off = tilt_rad > kTiltMax_rad;
  out.push_back(make_finding(
      "D07", off ? Severity::kWarning : Severity::kInfo, topic,
      {fmt::format("ground normal and gravity differ by {:.1f} deg", tilt_rad * kDegPerRad),
       off ? "T_body_lidar is wrong, or the recording starts on or beside a slope" : "",
       off ? "Check T_body_lidar and T_body_imu." : ""},
      {tilt_rad * kDegPerRad, kTiltMax_rad * kDegPerRad}));
}

}  // namespace rali::inspect
