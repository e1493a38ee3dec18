#include <array>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/drive/input/extrinsics_check.hpp"
#include "rali/drive/input/recording_probe.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::drive {
namespace {

constexpr double kUprightDeg = 15.0;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;

Finding origin_finding(const InputReport& report, Severity severity, std::string text) {
  Finding f;
  f.id = "D11";
  f.severity = severity;
  f.vehicle = report.vehicle;
  f.topic = report.lidar_topic;
  f.text = std::move(text);
  return f;
}

/// Names of the body in /tf_static, the usual ones first (REP-105).
constexpr std::array<const char*, 4> kBodyFrames = {"base_link", "body", "base", "base_footprint"};

struct InBody {
  std::string body_frame;
  geometry::SE3 T_body_sensor;
};

std::optional<InBody> find_in_body(const TfTree& tf, const std::string& frame) {
  for (const char* const body : kBodyFrames) {
    const std::optional<geometry::SE3> T = tf.find(body, frame);
    if (T) return InBody{body, *T};
  }
  return std::nullopt;
}

/// T_body_imu as given, or from /tf_static. A transform requested by `auto` may be missing.
Status decide_imu_pose(const InputOptions& options, const TfTree& tf, InputReport& report) {
  report.T_body_imu = options.T_body_imu;
  if (!options.imu_from_tf || !report.has_imu) return {};
  const bool named = !options.imu_tf_frame.empty();
  const std::string frame = named ? options.imu_tf_frame : report.imu_frame;
  if (const std::optional<InBody> found = find_in_body(tf, frame)) {
    report.T_body_imu = found->T_body_sensor;
    report.T_body_imu_origin = fmt::format("/tf_static, {} in {}", frame, found->body_frame);
    report.findings.push_back(origin_finding(
        report, Severity::kInfo,
        fmt::format("body of {} is {}; the IMU: {}", options.vehicle, found->body_frame,
                    extrinsics_in_words(report.T_body_imu, "body"))));
    return {};
  }
  const std::string missing =
      fmt::format("/tf_static has '{}' (IMU) in none of {}", frame, fmt::join(kBodyFrames, ", "));
  if (named) {
    return fail(ErrorCode::kInput,
                fmt::format("vehicles.{}.imu.T_body_imu.from_tf", options.vehicle), missing,
                "Give T_body_imu in numbers, or leave it out: body = IMU.");
  }
  report.T_body_imu = {};
  report.T_body_imu_origin = "body = IMU: " + missing;
  report.findings.push_back(
      origin_finding(report, Severity::kWarning, missing + ": the IMU is the body"));
  return {};
}

Status from_tf(const InputOptions& options, const TfTree& tf, InputReport& report) {
  const std::string imu_frame =
      options.imu_tf_frame.empty() ? report.imu_frame : options.imu_tf_frame;
  const std::string lidar_frame =
      options.lidar_tf_frame.empty() ? report.lidar_frame : options.lidar_tf_frame;
  const std::optional<geometry::SE3> T_imu_lidar = tf.find(imu_frame, lidar_frame);
  const std::optional<InBody> in_body =
      report.has_imu ? std::nullopt : find_in_body(tf, lidar_frame);
  if (T_imu_lidar || in_body) {
    report.T_body_lidar = in_body ? in_body->T_body_sensor : report.T_body_imu * *T_imu_lidar;
    report.T_body_lidar_origin = "/tf_static";
    return {};
  }
  if (options.lidar_tf_frame.empty()) return {};
  if (!report.has_imu) {
    return fail(ErrorCode::kInput,
                fmt::format("vehicles.{}.lidar.T_body_lidar.from_tf", options.vehicle),
                fmt::format("/tf_static has '{}' (LiDAR) in none of {}", lidar_frame,
                            fmt::join(kBodyFrames, ", ")));
  }
  return fail(ErrorCode::kInput,
              fmt::format("vehicles.{}.lidar.T_body_lidar.from_tf", options.vehicle),
              fmt::format("/tf_static does not connect '{}' (IMU) with '{}' (LiDAR)", imu_frame,
                          lidar_frame));
}

/// Turns an assumed T_body_lidar upright if it clearly contradicts a large ground.
void upright_by_ground(std::span<const PlaneDirection> planes, const geometry::Vec3& up_body,
                       InputReport& report) {
  const std::optional<double> tilt = ground_tilt_rad(planes, report.T_body_lidar.R, up_body);
  const std::vector<PlaneDirection> grounds =
      ground_candidates(planes, report.T_body_lidar.R, up_body);
  if (grounds.empty() || *tilt * kDegPerRad <= kUprightDeg) return;
  // The nearest large plane under the assumed rotation is taken as the ground: of all upright
  // orientations, this needs the smallest rotation.
  geometry::Vec3 ground_body = up_body;
  double best = -2.0;
  for (const PlaneDirection& plane : grounds) {
    const geometry::Vec3 n_body = report.T_body_lidar.R * plane.n_lidar;
    if (n_body.dot(up_body) <= best) continue;
    best = n_body.dot(up_body);
    ground_body = n_body;
  }
  report.T_body_lidar.R = geometry::rotation_between(ground_body, up_body) * report.T_body_lidar.R;
  report.T_body_lidar_origin = "ground";
}

/// A rotation that the user or the recording has given, and under which LiDAR and IMU turn
/// differently.
Status turning_contradicts(const InputOptions& options, InputReport& report) {
  const imu::MountingByTurning& turning = options.mounting;
  const geometry::Vec3 rpy_deg =
      kDegPerRad * geometry::rpy_from_rotation(report.T_body_imu.R * turning.R_imu_lidar);
  const std::string text = fmt::format(
      "T_body_lidar ({}) does not fit the turning of LiDAR and IMU: {:.0f} deg off, rpy_deg: "
      "[{:.1f}, {:.1f}, {:.1f}] fits to {:.0f} deg",
      report.T_body_lidar_origin, kDegPerRad * turning.assumed_misfit_rad, rpy_deg.x(), rpy_deg.y(),
      rpy_deg.z(), kDegPerRad * turning.misfit_rad);
  const std::string remedy = "See `rali doctor`.";
  if (options.extrinsics == ExtrinsicsCheck::kError) {
    return fail(ErrorCode::kInput, fmt::format("vehicles.{}.lidar.T_body_lidar", options.vehicle),
                text, remedy + " (--set checks.extrinsics=warn goes on.)");
  }
  Finding f = origin_finding(report, Severity::kWarning, text);
  f.remedy = remedy;
  f.value = kDegPerRad * turning.assumed_misfit_rad;
  report.findings.push_back(std::move(f));
  return {};
}

void report_what_was_assumed(const InputOptions& options, InputReport& report) {
  const std::string words = extrinsics_in_words(
      report.T_body_lidar, report.T_body_imu_origin.starts_with('/') ? "body" : "IMU");
  const bool known = options.T_body_lidar || !report.has_imu ||
                     report.T_body_lidar_origin == "/tf_static" ||
                     report.T_body_lidar_origin == "maker";
  Finding f = origin_finding(
      report, known ? Severity::kInfo : Severity::kWarning,
      fmt::format("lidar of {}: {} (from {})", options.vehicle, words, report.T_body_lidar_origin));
  if (!known) {
    f.effect = "A wrong lever arm or angle bends the map in turns.";
    f.remedy = fmt::format("Give vehicles.{}.lidar.T_body_lidar.", options.vehicle);
  }
  report.findings.push_back(std::move(f));
}

/// What the first scans show of the ground, if the vehicle stood.
struct GroundLook {
  std::vector<PlaneDirection> planes;  ///< empty: nothing to compare
  geometry::Vec3 up_body = geometry::Vec3::UnitZ();
};

GroundLook look_at_ground(std::span<const sensor::LidarScan> scans,
                          std::span<const sensor::ImuSample> imu, const ImuUnits& units,
                          const geometry::Mat3& R_body_imu) {
  const ImuStretch rest = quietest_stretch(imu);
  if (!rest.at_rest || scans.empty()) return {};
  return {plane_directions(scans),
          (R_body_imu * (units.accel_scale * rest.accel_mean)).normalized()};
}

/// The assumed rotation gives way to that of the turning, unless a large ground contradicts it.
void take_turning(const GroundLook& ground, InputReport& report) {
  const geometry::Mat3 R_body_lidar = report.T_body_imu.R * report.mounting.R_imu_lidar;
  if (ground_fits(ground.planes, report.T_body_lidar.R, ground.up_body) &&
      !ground_fits(ground.planes, R_body_lidar, ground.up_body)) {
    return;
  }
  report.T_body_lidar.R = R_body_lidar;
  report.T_body_lidar_origin = "turning";
}

/// By the turning of both sensors if it decides, else by gravity and the ground. A rotation that
/// was given is refused by the ground alone, or where both contradict it; by the turning alone it
/// is questioned.
Status judge_rotation(InputOptions options, const GroundLook& ground, InputReport& report) {
  const bool assumed = report.T_body_lidar_origin == "assumed zero";
  report.mounting = options.mounting;
  report.mounting_in_question = assumed && report.has_imu;
  const imu::MountingVerdict turning = options.mounting.verdict;
  if (turning == imu::MountingVerdict::kAgrees) return {};
  if (assumed && turning == imu::MountingVerdict::kContradicts) {
    take_turning(ground, report);
    return {};
  }
  if (assumed) upright_by_ground(ground.planes, ground.up_body, report);
  Result<FindingList> checked =
      check_extrinsics(ground.planes, report.T_body_lidar.R, ground.up_body, options);
  if (turning == imu::MountingVerdict::kContradicts) {
    if (checked && checked->empty()) options.extrinsics = ExtrinsicsCheck::kWarn;
    return turning_contradicts(options, report);
  }
  if (!checked) return tl::make_unexpected(checked.error());
  report.mounting_in_question = report.mounting_in_question || !checked->empty();
  for (Finding& f : *checked) report.findings.push_back(std::move(f));
  return {};
}

}  // namespace

Status decide_extrinsics(const InputOptions& options, const TfTree& tf,
                         std::span<const sensor::LidarScan> scans,
                         std::span<const sensor::ImuSample> imu, const ImuUnits& units,
                         InputReport& report) {
  if (Status status = decide_imu_pose(options, tf, report); !status) return status;
  report.T_body_lidar_origin = "assumed zero";
  if (options.T_body_lidar) {
    report.T_body_lidar = *options.T_body_lidar;
    report.T_body_lidar_origin = "settings";
  } else if (report.has_imu || !options.lidar_tf_frame.empty()) {
    if (Status status = from_tf(options, tf, report); !status) return status;
    const auto maker = maker_extrinsics(report.cloud_format.model, report.imu_topic);
    if (maker && report.T_body_lidar_origin == "assumed zero") {
      report.T_body_lidar = report.T_body_imu * *maker;
      report.T_body_lidar_origin = "maker";
    }
  }
  if (options.extrinsics != ExtrinsicsCheck::kOff) {
    const GroundLook ground = look_at_ground(scans, imu, units, report.T_body_imu.R);
    if (Status status = judge_rotation(options, ground, report); !status) return status;
  }
  report_what_was_assumed(options, report);
  return {};
}

}  // namespace rali::drive
