#include "rali/inspect/rotation_findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/inspect/make_finding.hpp"

namespace rali::inspect {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kOffsetMin_s = 0.005;
/// Above this rotation during the LiDAR-IMU time offset walls double visibly: 0.5 deg is 9 cm at 10
/// m.
constexpr double kSmearMax_rad = 0.5 / kDegPerRad;
constexpr double kMisfitMax = 0.15;     ///< about 9 degrees
constexpr double kClearlyBetter = 0.4;  ///< fraction of the given rotation's misfit
/// At slower rotation the noise of LiDAR poses dominates.
constexpr double kTurnRateSeen_radps = 0.1;
constexpr double kSecondAxisMin = 0.1;
constexpr double kDegenerateMax = 0.2;  ///< of the scans
constexpr double kUnitFactor = 2.0;     ///< more is no scale error
constexpr double kTiltMax_rad = 8.0 / kDegPerRad;
constexpr double kVaultMax_rad = 40.0 / kDegPerRad;  ///< of a plane above: a vault's side
constexpr double kAlike_rad = 5.0 / kDegPerRad;

struct Candidate {
  std::string name;
  geometry::Mat3 R;
  double misfit = 0.0;
};

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

Candidate best_other(const geometry::Mat3& R_given, std::span<const imu::LidarTurn> lidar,
                     std::span<const sensor::ImuSample> imu, const imu::RotationStudy& study) {
  std::vector<Candidate> others{{"its inverse", R_given.transpose(), 0.0}};
  for (const geometry::Mat3& swap : axis_swaps()) {
    others.push_back({"swapped axes", R_given * swap, 0.0});
  }
  others.push_back({"the rotation estimated from the data", study.best.R_imu_lidar, 0.0});
  for (Candidate& c : others) c.misfit = imu::misfit_of(c.R, lidar, imu, study);
  // On ties the first: the inverse is a more likely mistake than an equivalent axis swap.
  return *std::min_element(others.begin(), others.end(),
                           [](const auto& a, const auto& b) { return a.misfit < 0.9 * b.misfit; });
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
  const bool one_axis = study.second_axis_fraction < kSecondAxisMin;
  const geometry::Mat3 R_given =
      given.R_body_imu.transpose() * given.R_body_lidar.value_or(geometry::Mat3::Identity());
  const double misfit = imu::misfit_of(R_given, lidar, imu, study);
  const Candidate other = best_other(R_given, lidar, imu, study);
  const std::string which =
      given.R_body_lidar ? "T_body_lidar (" + given.origin + ")" : "the identity as T_body_lidar";
  const bool wrong = misfit > kMisfitMax && other.misfit < kClearlyBetter * misfit;
  // The misfit of the best rotation is noise of the LiDAR poses; only the excess counts against a
  // rotation.
  const double minimum = std::min(other.misfit, study.best.misfit);
  const double excess = std::sqrt(std::max(misfit * misfit - minimum * minimum, 0.0));
  const double chance = 2.0 * misfit * std::sqrt(3.0 / static_cast<double>(study.pairs));
  if (!wrong && minimum > kMisfitMax && excess < std::max(kMisfitMax, chance)) {
    out.push_back(make_finding(
        "D11", Severity::kInfo, "",
        {fmt::format("{} fits the turning as well as any other; it turned too little to decide",
                     which),
         "", "Turn the vehicle left and right a few times at the start of a recording."},
        {misfit * kDegPerRad, kMisfitMax * kDegPerRad}));
    return;
  }
  if (!wrong) {
    out.push_back(make_finding(
        "D11", misfit > kMisfitMax ? Severity::kWarning : Severity::kInfo, "",
        {fmt::format(
             "{} fits the turning to {:.1f} deg{}", which, misfit * kDegPerRad,
             one_axis ? "; the angle about the axis it turned about is not observable" : ""),
         "", ""},
        {misfit * kDegPerRad, kMisfitMax * kDegPerRad}));
    return;
  }
  const geometry::Mat3 R_body_lidar = given.R_body_imu * other.R;
  out.push_back(make_finding(
      "D11", given.R_body_lidar ? Severity::kError : Severity::kWarning, "",
      {fmt::format("{} does not fit, {} does: {:.1f} against {:.1f} deg", which, other.name,
                   other.misfit * kDegPerRad, misfit * kDegPerRad),
       "the map falls apart at the first turn",
       one_axis
           ? "Check the direction of T_body_lidar; turn about a second axis to have it estimated."
           : fmt::format("Set lidar.T_body_lidar rpy_deg: {}.", rpy_text(R_body_lidar))},
      {misfit * kDegPerRad, other.misfit * kDegPerRad}));
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
