#include "judge.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "rali/assess/run_tables.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::campaign {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kError_m = 0.3;
constexpr double kSigmas = 4.0;
constexpr double kLong_s = 2.0;
constexpr double kNear_s = 5.0;      // a finding this close to the failure counts as its report
constexpr double kWholeRatio = 0.2;  // a finding over more of the run does not locate a failure
constexpr double kNeesStep_s = 5.0;
constexpr double kTruthGap_s = 0.1;

/// Poses of a file with their position covariances, in the file's frame.
struct Estimates {
  eval::PoseList poses;
  std::vector<Mat3> position;  ///< covariance
};

std::optional<Estimates> read(const std::string& path_without_ending) {
  const auto tum = io::read_tum(path_without_ending + ".tum");
  if (!tum || tum->poses.empty()) return std::nullopt;
  Estimates out;
  std::vector<Time> stamps;
  for (const io::StampedPose& p : tum->poses) {
    out.poses.push_back({p.t, p.T});
    stamps.push_back(p.t);
  }
  const auto covariances = assess::read_covariances(path_without_ending + ".cov.csv", out.poses);
  for (std::size_t i = 0; i < out.poses.size(); ++i) {
    Mat3 P = Mat3::Identity() * 1e-12;
    if (covariances) P = (*covariances)[i].bottomRightCorner<3, 3>();
    out.position.push_back(P);
  }
  return out;
}

/// Compares with ground truth, given the pose T_world_frame of the estimate's frame.
TrackScore score(const Estimates& estimates, const Track& track, const SE3& T_world_frame,
                 Time t_start) {
  TrackScore out;
  double squares = 0.0;
  double nees = 0.0;
  int nees_count = 0;
  std::optional<Time> t_nees;
  std::optional<double> bad_since_s;
  double last_s = 0.0;
  const auto close = [&](double at_s) {
    if (bad_since_s && at_s - *bad_since_s > kLong_s) {
      out.failures_s.emplace_back(*bad_since_s, at_s);
    }
    bad_since_s.reset();
  };
  for (std::size_t i = 0; i < estimates.poses.size(); ++i) {
    const eval::StampedPose& pose = estimates.poses[i];
    const auto truth = eval::pose_at(track.truth, pose.t, kTruthGap_s);
    if (!truth) continue;
    const double t_s = seconds_between(t_start, pose.t);
    const Vec3 e = T_world_frame.R.transpose() * (truth->p - T_world_frame * pose.T.p);
    const double error_m = e.norm();
    const Mat3& P = estimates.position[i];
    const Vec3 u = error_m > 1e-9 ? Vec3(e / error_m) : Vec3::UnitX();
    const double sigma_m = std::sqrt(std::max(0.0, u.dot(P * u)));
    ++out.poses;
    squares += error_m * error_m;
    out.max_m = std::max(out.max_m, error_m);
    out.end_m = error_m;
    out.sigma_max_m = std::max(out.sigma_max_m, std::sqrt(P.diagonal().maxCoeff()));
    const bool bad = error_m > kError_m && error_m > kSigmas * sigma_m;
    // Written so that NaN is bad.
    if (bad || !std::isfinite(error_m)) {
      if (!bad_since_s) bad_since_s = t_s;
    } else {
      close(t_s);
    }
    last_s = t_s;
    if (t_nees && seconds_between(*t_nees, pose.t) < kNeesStep_s) continue;
    t_nees = pose.t;
    const double x = e.dot(P.ldlt().solve(e)) / 3.0;
    if (i > 0 && std::isfinite(x)) {
      nees += x;
      ++nees_count;
    }
  }
  close(last_s);
  if (out.poses > 0) out.rmse_m = std::sqrt(squares / static_cast<double>(out.poses));
  if (nees_count > 0) out.nees_position = nees / nees_count;
  return out;
}

/// Pose of the estimate's frame in the world if both agree at the first pose.
std::optional<SE3> frame_at_first(const Estimates& estimates, const Track& track) {
  for (const eval::StampedPose& pose : estimates.poses) {
    if (const auto truth = eval::pose_at(track.truth, pose.t, kTruthGap_s)) {
      return *truth * pose.T.inverse();
    }
  }
  return std::nullopt;
}

/// The same with z vertical: in a gravity-aligned map a tilt is an error. The tilt error of the
/// first pose, before gravity was estimated, must not count for later poses.
SE3 upright(const SE3& T_world_frame, const SE3& first) {
  const Vec3 forward = T_world_frame.R * Vec3::UnitX();
  SE3 out;
  out.R = Eigen::AngleAxisd(std::atan2(forward.y(), forward.x()), Vec3::UnitZ()).toRotationMatrix();
  out.p = T_world_frame * first.p - out.R * first.p;
  return out;
}

/// A finding that the pose is or may be lost.
bool is_lost_finding(const Finding& f) {
  static const std::set<std::string> ids = {"odometry.diverged", "odometry.contradiction",
                                            "monitor.contradiction", "monitor.walls",
                                            "fleet.withdrawn"};
  return f.severity != Severity::kInfo && ids.contains(f.id);
}

/// A finding that the pose is less certain than elsewhere.
bool is_degenerate_finding(const Finding& f) { return f.id == "odometry.degenerate"; }

bool covers(const Finding& f, const SilentFailure& failure, const Recording& recording) {
  if (f.vehicle != failure.vehicle || f.t.ns == 0) return false;
  const double start_s = seconds_between(recording.t_start(), f.t);
  const double end_s = f.t_end.ns > 0 ? seconds_between(recording.t_start(), f.t_end) : start_s;
  const double run_s = seconds_between(recording.t_start(), recording.t_end());
  if (end_s - start_s > kWholeRatio * run_s) return false;
  return start_s <= failure.end_s + kNear_s && end_s >= failure.start_s - kNear_s;
}

/// Adds failures that were not reported.
void add_silent(const TrackScore& track, const std::string& vehicle, const char* trajectory,
                const Recording& recording, const FindingList& findings, RunScore& out) {
  for (const auto& [start_s, end_s] : track.failures_s) {
    SilentFailure failure{vehicle, trajectory, start_s, end_s, track.max_m, track.sigma_max_m};
    const auto reported = [&](auto&& is_one) {
      return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
        return is_one(f) && covers(f, failure, recording);
      });
    };
    if (reported(is_lost_finding)) continue;
    if (reported(is_degenerate_finding)) {
      ++out.only_degenerate;
    } else {
      out.silent.push_back(failure);
    }
  }
}

/// Poses of `kind` of a vehicle, with the stamps that its scans had in the recording: the mapping
/// moves them to the clock of the inertial sensor, by an offset that it reports.
std::optional<Estimates> read(const drive::MapSummary& summary, const char* kind, VehicleId id) {
  const auto& vehicle = summary.vehicles[id.value];
  auto out = read(summary.out_dir + '/' + kind + '/' + vehicle.name);
  if (!out) return std::nullopt;
  const Duration added = Duration::from_s(vehicle.input.lidar_time_offset.value_s);
  for (eval::StampedPose& pose : out->poses) pose.t = pose.t - added;
  return out;
}

/// Frame of the final poses of a group: by all of them, or by the first of its first vehicle.
std::optional<SE3> final_frame(const Recording& recording, const drive::MapSummary& summary,
                               const std::vector<VehicleId>& group, bool best_fit) {
  eval::PairList pairs;
  std::optional<SE3> first;
  for (const VehicleId id : group) {
    const Track& track = recording.tracks()[id.value];
    const auto estimates = read(summary, "trajectory", id);
    if (!estimates) continue;
    if (!first) first = frame_at_first(*estimates, track);
    if (!best_fit && first) return first;
    for (const eval::StampedPose& pose : estimates->poses) {
      if (const auto truth = eval::pose_at(track.truth, pose.t, kTruthGap_s)) {
        pairs.push_back({pose.t, pose.T, *truth, pairs.size()});
      }
    }
  }
  // Positions on one line leave the rotation about it unobservable.
  const auto aligned = eval::align(pairs, eval::Alignment::kSe3);
  return aligned ? std::optional<SE3>(*aligned) : first;
}

/// Scores the odometry and counts the findings about the vehicle.
void judge_alone(const Recording& recording, const drive::MapSummary& summary, VehicleId id,
                 RunScore& out) {
  const Track& track = recording.tracks()[id.value];
  VehicleScore score_v;
  score_v.name = track.name;
  score_v.distance_m = track.distance_m;
  score_v.diverged_s = summary.vehicles[id.value].diverged_s;
  for (const Finding& f : summary.findings) {
    score_v.pose_findings += is_lost_finding(f) && f.vehicle == track.name ? 1 : 0;
  }
  out.lost = out.lost || score_v.diverged_s > 0.0;
  if (const auto odometry = read(summary, "odometry", id)) {
    if (const auto T = frame_at_first(*odometry, track)) {
      score_v.odometry = score(*odometry, track, *T, recording.t_start());
      add_silent(*score_v.odometry, track.name, "odometry", recording, summary.findings, out);
    }
  }
  out.vehicles.push_back(std::move(score_v));
}

/// Live poses are in map, which is aligned at the first pose of the first vehicle.
std::optional<SE3> live_frame(const Recording& recording, const drive::MapSummary& summary,
                              const std::vector<VehicleId>& group) {
  for (const VehicleId id : group) {
    const Track& track = recording.tracks()[id.value];
    const auto live = read(summary, "live", id);
    const auto T = live ? frame_at_first(*live, track) : std::nullopt;
    if (!T) continue;
    return summary.vehicles[id.value].levelled ? upright(*T, live->poses.front().T) : *T;
  }
  return std::nullopt;
}

/// Scores live and final poses of vehicles that share a frame.
void judge_group(const Recording& recording, const drive::MapSummary& summary,
                 const std::vector<VehicleId>& group, RunScore& out) {
  const auto T_live = live_frame(recording, summary, group);
  const auto T_final = final_frame(recording, summary, group, true);
  const auto T_first = final_frame(recording, summary, group, false);
  for (const VehicleId id : group) {
    const Track& track = recording.tracks()[id.value];
    VehicleScore& v = out.vehicles[id.value];
    if (const auto live = read(summary, "live", id); live && T_live) {
      v.live = score(*live, track, *T_live, recording.t_start());
      add_silent(*v.live, track.name, "live", recording, summary.findings, out);
    }
    const auto path = read(summary, "trajectory", id);
    if (!path || !T_final) continue;
    v.final = score(*path, track, *T_final, recording.t_start());
    if (T_first) {
      v.final->nees_position = score(*path, track, *T_first, recording.t_start()).nees_position;
    }
    add_silent(*v.final, track.name, "final", recording, summary.findings, out);
  }
}

/// RMSE of all final poses of the largest groups; 0 if there are none.
double rmse_of_largest(const std::vector<std::vector<VehicleId>>& groups, const RunScore& out) {
  std::size_t largest = 0;
  for (const std::vector<VehicleId>& group : groups) largest = std::max(largest, group.size());
  double squares = 0.0;
  double poses = 0.0;
  for (const std::vector<VehicleId>& group : groups) {
    if (group.size() != largest) continue;
    for (const VehicleId id : group) {
      const VehicleScore& v = out.vehicles[id.value];
      if (!v.final) continue;
      squares += v.final->rmse_m * v.final->rmse_m * static_cast<double>(v.final->poses);
      poses += static_cast<double>(v.final->poses);
    }
  }
  return poses > 0.0 ? std::sqrt(squares / poses) : 0.0;
}

}  // namespace

RunScore judge_run(const Recording& recording, const drive::MapSummary& summary) {
  RunScore out;
  out.solvable = judge_solvable(recording);
  out.gaps = summary.gaps;
  out.groups = std::max<std::size_t>(1, summary.fleet.groups.size());
  out.ranges = summary.ranges.total;
  out.ranges_used = summary.ranges.used();
  std::set<std::string> reported;
  for (const Finding& f : summary.findings) {
    if (f.severity != Severity::kInfo) reported.insert(f.id);
  }
  out.reported.assign(reported.begin(), reported.end());
  for (std::size_t v = 0; v < recording.tracks().size(); ++v) {
    judge_alone(recording, summary, VehicleId{static_cast<std::uint16_t>(v)}, out);
  }
  std::vector<std::vector<VehicleId>> groups = summary.fleet.groups;
  if (groups.empty()) {
    for (std::size_t v = 0; v < recording.tracks().size(); ++v) {
      groups.push_back({VehicleId{static_cast<std::uint16_t>(v)}});
    }
  }
  for (const std::vector<VehicleId>& group : groups) judge_group(recording, summary, group, out);
  out.fleet_rmse_m = rmse_of_largest(groups, out);
  return out;
}

}  // namespace rali::campaign
