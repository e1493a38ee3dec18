#include "rali/drive/run_findings.hpp"

#include <numbers>

#include <fmt/format.h>

#include "rali/base/counted.hpp"

namespace rali::drive {
namespace {

/// A mark residual beyond this many of its sigmas is a warning.
constexpr double kMarkSigmas = 3.0;

/// Beyond these limits the gyro's rotation differs from the LiDAR's. A tenth is LiDAR noise at slow
/// turns; a factor of two is not.
constexpr double kGyroRatioMin = 0.5, kGyroRatioMax = 2.0;

}  // namespace

std::optional<Finding> gyro_finding(const VehicleRun& run, const InputReport& input) {
  const double ratio = run.gyro_ratio();
  if (ratio == 0.0 || (ratio > kGyroRatioMin && ratio < kGyroRatioMax)) return std::nullopt;
  Finding f;
  f.id = "D09";
  f.vehicle = run.name();
  f.topic = input.imu_topic;
  f.value = ratio;
  f.limit = kGyroRatioMax;
  f.text = fmt::format("the gyro turned {:.2f} times as much as the LiDAR", ratio);
  f.remedy = ratio > 30.0 ? "Its unit is deg/s: set imu.gyro_unit: deg_s."
                          : "Check imu.gyro_unit and the frame of the IMU.";
  return f;
}

FindingList noise_findings(const VehicleSummary& vehicle) {
  constexpr double kFactor = 3.0;  // data sheets are not more accurate than that
  FindingList findings;
  const auto compare = [&](const char* sensor, const std::optional<double>& measured, double stated,
                           const char* unit) {
    if (!measured || !(stated > 0.0)) return;
    const double ratio = *measured / stated;
    if (ratio < kFactor && ratio > 1.0 / kFactor) return;
    Finding f;
    f.id = "D10";
    f.severity = Severity::kInfo;
    f.vehicle = vehicle.name;
    f.topic = vehicle.input.imu_topic;
    f.text = fmt::format("{} noise while driving is {:.2g} {}, {:.2g} times what imu.noise states",
                         sensor, *measured, unit, ratio);
    f.effect = "the measured value is used";
    f.value = ratio;
    f.limit = kFactor;
    findings.push_back(std::move(f));
  };
  compare("accelerometer", vehicle.imu_noise.accel_mps2_rthz,
          vehicle.imu_noise_stated.accel_mps2_rthz, "m/s2/rtHz");
  compare("gyro", vehicle.imu_noise.gyro_radps_rthz, vehicle.imu_noise_stated.gyro_radps_rthz,
          "rad/s/rtHz");
  return findings;
}

Finding no_pose_finding(const std::string& vehicle, const InputReport& input) {
  Finding f;
  f.id = "map.no_pose";
  f.severity = Severity::kError;
  f.vehicle = vehicle;
  f.text = fmt::format("no pose from {}", counted(input.scans, "scan"));
  f.remedy = input.scans > 0              ? "See run.log for what was refused."
             : input.gaps.empty_scans > 0 ? "See rali doctor."
                                          : "Let start_s and duration_s leave a part of the "
                                            "recording.";
  return f;
}

namespace {

std::string start_text(const fleet::RejectedStart& start, const std::string& relative_to) {
  if (start.contradicted_by > 0) {
    return fmt::format(
        "the start pose relative to {} does not fit the scans: where both should see the same, one "
        "has walls where the other looks through, in {} places, and none fits",
        relative_to, start.contradicted_by);
  }
  return fmt::format("the start pose relative to {} is {:.2f} m, {:.0f} deg off all else",
                     relative_to, start.off_m, start.off_rad * 180.0 / std::numbers::pi);
}

}  // namespace

FindingList fleet_findings(const fleet::FleetEstimate& estimate,
                           const std::vector<std::string>& names) {
  FindingList findings;
  for (const fleet::RejectedStart& start : estimate.rejected_starts) {
    Finding f;
    f.id = "fleet.prior_denied";
    f.vehicle = names[start.vehicle.value];
    f.value = start.off_m;
    f.text = start_text(start, names[start.relative_to.value]);
    f.effect = "It was not used.";
    f.remedy = "Measure it again, see priors.";
    findings.push_back(std::move(f));
  }
  for (const fleet::VehicleFrame& frame : estimate.frames) {
    if (frame.group == 0) continue;
    Finding f;
    f.id = "fleet.not_joined";
    f.vehicle = names[frame.vehicle.value];
    f.text = "is in a frame of its own";
    if (estimate.groups[frame.group].size() > 1) f.text = "is not in the frame of the map";
    if (!frame.waits_for.empty()) f.text += ": " + frame.waits_for;
    f.effect = "map.* does not hold it.";
    findings.push_back(std::move(f));
  }
  return findings;
}

Finding withdrawal_finding(const Withdrawal& withdrawal, const std::string& vehicle) {
  Finding f;
  f.id = "fleet.withdrawn";
  f.vehicle = vehicle;
  f.t = withdrawal.t_joined;
  f.t_end = withdrawal.t_withdrawn;
  f.text = fmt::format("its live poses of {:.0f} s were in a frame that is contradicted",
                       seconds_between(withdrawal.t_joined, withdrawal.t_withdrawn));
  if (!withdrawal.reason.empty()) f.text += ": " + withdrawal.reason;
  f.effect = "It has no live pose in the map until it is joined again.";
  return f;
}

Finding no_map_finding() {
  Finding f;
  f.id = "map.empty";
  f.severity = Severity::kError;
  f.text = "no keyframe: there is no map";
  return f;
}

Finding no_imu_rate_finding(const std::string& vehicle) {
  Finding f;
  f.id = "output.imu_rate";
  f.vehicle = vehicle;
  f.text = "no inertial data: there are no poses at their rate";
  return f;
}

Finding lost_mark_finding(const std::string& vehicle, Time t, bool in_map) {
  Finding f;
  f.id = "output.site";
  f.vehicle = vehicle;
  f.t = t;
  f.text = in_map ? "a mark is left out: the vehicle has no pose at its time"
                  : "a mark is left out: the vehicle is not joined to the map";
  f.remedy = "Give stamps as they are in the recordings.";
  return f;
}

Finding no_site_finding(const Error& error) {
  Finding f;
  f.id = "output.site";
  f.severity = Severity::kError;
  f.text = error.message();
  f.effect = "the map has no site coordinates";
  return f;
}

Finding site_finding(const SiteFrame& site) {
  Finding f;
  f.id = "output.site";
  f.severity = Severity::kInfo;
  const MarkResidual* worst = &site.residuals.front();
  for (const MarkResidual& mark : site.residuals) {
    if (mark.residual_site_m.norm() > worst->residual_site_m.norm()) worst = &mark;
  }
  f.value = worst->residual_site_m.norm();
  f.limit = kMarkSigmas * worst->sigma_m;
  f.text = fmt::format(
      "map on the site by {} marks: rms {:.3f} m, largest residual {:.3f} m ({} at {:.1f} s)",
      site.residuals.size(), site.rms_m, f.value, worst->vehicle, worst->t.s());
  if (f.value > f.limit) {
    f.severity = Severity::kWarning;
    f.vehicle = worst->vehicle;
    f.remedy = "Check this mark's coordinates and the time at which the vehicle stood over it.";
  }
  return f;
}

Finding failed_finding(const std::string& vehicle, const Error& error) {
  Finding f;
  f.id = "D19";
  f.severity = Severity::kError;
  f.vehicle = vehicle;
  f.text = error.message();
  return f;
}

}  // namespace rali::drive
