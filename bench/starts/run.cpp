#include "run.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <variant>

#include <Eigen/Eigenvalues>

#include "rali/base/executor.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::bench {

namespace {

using geometry::SE3;

double worst_sigma_m(const geometry::Mat6& covariance) {
  const geometry::Mat3 P = covariance.bottomRightCorner<3, 3>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<geometry::Mat3>(P).eigenvalues().maxCoeff());
}

/// Outputs of one run, not yet scored.
struct Outcome {
  std::vector<vehicle::PoseEstimate> poses;
  FindingList findings;
};

Outcome drive(const ReferencedScans& scans, const vehicle::VehicleSettings& settings) {
  vehicle::Vehicle vehicle(VehicleId{0}, settings);
  SerialExecutor executor;
  vehicle::OutputList outputs;
  for (const ReferencedScan& s : scans) vehicle.step(s.scan, executor, outputs);
  vehicle.step(vehicle::EndOfData{}, executor, outputs);
  Outcome out;
  for (const vehicle::Output& output : outputs) {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) out.poses.push_back(*pose);
    const auto* f = std::get_if<Finding>(&output);
    if (f != nullptr && f->severity != Severity::kInfo) out.findings.push_back(*f);
  }
  return out;
}

ReferencedScans stretch(const ReferencedScans& scans, const StartOptions& options) {
  ReferencedScans out;
  const Time first = scans.front().scan->t_end;
  for (const ReferencedScan& s : scans) {
    const double t_s = (s.scan->t_end - first).s();
    const bool ended = options.duration_s > 0.0 && t_s > options.start_s + options.duration_s;
    if (t_s >= options.start_s && !ended) out.push_back(s);
  }
  return out;
}

}  // namespace

StartRun run_start(const ReferencedScans& all, const StartOptions& options,
                   const vehicle::VehicleSettings& settings, double limit_m) {
  constexpr double kDegree = 180.0 / std::numbers::pi;
  constexpr double kSigmas = 3.5;
  const ReferencedScans scans = stretch(all, options);
  StartRun run;
  if (scans.empty()) return run;
  Outcome outcome = drive(scans, settings);
  run.findings = std::move(outcome.findings);
  std::map<std::int64_t, SE3> reference;
  for (std::size_t k = 0; k < scans.size(); ++k) {
    reference[scans[k].scan->t_end.ns] = scans[k].T_map_lidar;
    if (k > 0) run.path_m += (scans[k].T_map_lidar.p - scans[k - 1].T_map_lidar.p).norm();
  }
  std::optional<SE3> T_map_local;
  for (const vehicle::PoseEstimate& estimate : outcome.poses) {
    const SE3& T_ref = reference.at(estimate.t.ns);
    if (!T_map_local) T_map_local = T_ref * estimate.T_local_body.inverse();
    const SE3 T_est = *T_map_local * estimate.T_local_body;
    StartPose& pose = run.poses.emplace_back();
    pose.t_s = (estimate.t - scans.front().scan->t_end).s();
    pose.error_m = (T_est.p - T_ref.p).norm();
    pose.error_deg = kDegree * geometry::so3_log(T_ref.R.transpose() * T_est.R).norm();
    pose.sigma_m = worst_sigma_m(estimate.covariance);
    pose.cut = estimate.quality == vehicle::PoseQuality::kDiverged;
    pose.matches = estimate.matches;
    run.lost = run.lost || pose.cut;
    if (pose.cut) continue;
    run.error_max_m = std::max(run.error_max_m, pose.error_m);
    const bool reported = run.lost && pose.error_m < kSigmas * pose.sigma_m;
    if (pose.error_m > limit_m && !reported) {
      run.silent_max_m = std::max(run.silent_max_m, pose.error_m);
    }
  }
  return run;
}

}  // namespace rali::bench
