#include "rali/fleet/centre/scan_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "rali/fleet/frames/information.hpp"

namespace rali::fleet {

using geometry::SE3;

namespace {

/// Assumed odometry drift per metre travelled: for search regions, not for the covariance of
/// evidence.
constexpr double kDriftPerMetre = 0.01;
constexpr double kTurnPerMetre_rad = 0.0005;
/// A direction with a larger sigma counts as unconstrained.
constexpr double kUnknown_m = 10.0;

SE3 T_level_body(const VehiclePath& path, std::size_t node) {
  return T_level_odom(path) * path.nodes()[node].step->T_odom_body;
}

/// Covariance of (heading, position) of a node in its path's levelled odom, as the odometry
/// reported it.
Mat4 drift_of(const VehiclePath& path, std::size_t node) {
  const Increment& step = *path.nodes()[node].step;
  const geometry::Mat6& P = step.covariance;
  const geometry::Mat3 R = T_level_odom(path).R;
  const geometry::Mat3 R_body = R * step.T_odom_body.R;
  Mat4 out = Mat4::Zero();
  out(0, 0) = R_body.row(2) * P.topLeftCorner<3, 3>() * R_body.row(2).transpose();
  out.bottomRightCorner<3, 3>() = R * P.bottomRightCorner<3, 3>() * R.transpose();
  return out;
}

Mat4 turned(const Mat4& covariance, double yaw_rad) {
  Mat4 G = Mat4::Identity();
  G.bottomRightCorner<3, 3>() = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
  return G * covariance * G.transpose();
}

/// Information on the position, with the rotation of (rotation, translation) marginalised.
geometry::Mat3 place_known(const geometry::Mat6& information) {
  constexpr double kMin = 1e-9;  // regularises rotations without information
  const geometry::Mat3 rotation =
      information.topLeftCorner<3, 3>() + kMin * geometry::Mat3::Identity();
  const geometry::Mat3 place =
      information.bottomRightCorner<3, 3>() -
      information.bottomLeftCorner<3, 3>() *
          geometry::Mat3(rotation.ldlt().solve(information.topRightCorner<3, 3>()));
  return 0.5 * (place + place.transpose());
}

}  // namespace

std::optional<NodeOfPath> node_of(std::span<const VehiclePath> paths, KeyframeId keyframe) {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].vehicle() != keyframe.vehicle) continue;
    if (const auto node = paths[i].node_of(keyframe.seq)) return NodeOfPath{i, *node};
  }
  return std::nullopt;
}

namespace {

/// A node on its path, in its levelled odom.
ComparedBody compared_body(const VehiclePath& path, std::size_t node) {
  const auto sample = [&path](std::size_t k) {
    const geometry::Mat3 place_m2 = drift_of(path, k).bottomRightCorner<3, 3>();
    return PathSample{path.nodes()[k].t, T_level_body(path, k).p, place_m2};
  };
  return {sample(0), sample(node)};
}

}  // namespace

PoseEvidence evidence_between(std::span<const VehiclePath> paths, const NodeOfPath& target,
                              const NodeOfPath& source, const SE3& T_target_source,
                              const geometry::Mat6& information, const InitSettings& settings) {
  const VehiclePath& of_target = paths[target.path];
  const VehiclePath& of_source = paths[source.path];
  PoseEvidence evidence = keyframe_evidence(
      stream_of(of_source), stream_of(of_target), T_level_body(of_source, source.node),
      T_level_body(of_target, target.node), T_target_source, information, settings);
  evidence.on_a = compared_body(of_source, source.node);
  evidence.on_b = compared_body(of_target, target.node);
  return evidence;
}

namespace {

PoseEvidence evidence_of(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                         const LoopCandidate& compared, const places::Placement& placement,
                         const InitSettings& settings) {
  const PathSubmap& target = submaps[compared.target];
  const PathSubmap& source = submaps[compared.source];
  const places::BodyRelation relation =
      places::between_bodies(placement.registration, target.submap, source.submap);
  return evidence_between(paths, {target.path, target.node}, {source.path, source.node},
                          relation.T_target_source, relation.information, settings);
}

}  // namespace

void add_scan_evidence(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                       const LoopFound& found, const EvidenceKind& kind,
                       const InitSettings& settings, FrameSolver& solver) {
  const PathSubmap& target = submaps[found.candidate.target];
  const PathSubmap& source = submaps[found.candidate.source];
  if (target.path == source.path) return;
  const places::Recognition& r = found.recognition;
  const std::size_t reported = r.usable() ? 1 : r.placements.size();  // the others are rejected
  for (const places::Placement& placement : std::span(r.placements).first(reported)) {
    PoseEvidence evidence = evidence_of(paths, submaps, found.candidate, placement, settings);
    evidence.tested = kind.tested;
    evidence.unrivalled = !kind.tested && r.usable() && r.certainty == places::Certainty::kUnique;
    evidence.group = kind.group;
    solver.add_evidence(evidence);
  }
}

namespace {

/// The frames are those of the paths' starts: the drift until the compared bodies is unknown.
bool agrees(std::span<const VehiclePath> paths, const NodeOfPath& target, const NodeOfPath& source,
            const PoseEvidence& e, const PathFrames& frames) {
  if (frames.group[target.path] != frames.group[source.path]) return false;
  const auto T_map_level = [&](std::size_t path) {
    return frames.T_map_odom[path] * T_level_odom(paths[path]).inverse();
  };
  const YawPose T = YawPose::of(T_map_level(target.path).inverse() * T_map_level(source.path));
  Vec4 off;
  off[0] = wrapped(T.yaw_rad - e.yaw_rad);
  off.tail<3>() = T * e.pivot_a_m - e.place_b_m;
  const Mat4 drift = drift_of(paths[target.path], target.node) +
                     turned(drift_of(paths[source.path], source.node), e.yaw_rad);
  return off.dot(with_error(e.information, drift) * off) < e.wrong_chi2;
}

}  // namespace

bool agrees(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
            const LoopFound& found, const PathFrames& frames, const InitSettings& settings) {
  if (!found.recognition.usable()) return false;
  const PoseEvidence e =
      evidence_of(paths, submaps, found.candidate, found.recognition.placements.front(), settings);
  const PathSubmap& target = submaps[found.candidate.target];
  const PathSubmap& source = submaps[found.candidate.source];
  return agrees(paths, {target.path, target.node}, {source.path, source.node}, e, frames);
}

bool agrees(std::span<const VehiclePath> paths, const Loop& loop, const PathFrames& frames,
            const InitSettings& settings) {
  const auto target = node_of(paths, loop.from), source = node_of(paths, loop.to);
  if (!target || !source) return false;
  const PoseEvidence e =
      evidence_between(paths, *target, *source, loop.T_from_to, loop.information, settings);
  return agrees(paths, *target, *source, e, frames);
}

namespace {

/// Predicted transforms of submaps of two paths.
/// @param T_common_odom of all paths, of which those two are used
/// @param start_m where `path` starts, in the common frame: a heading error displaces its submaps
/// far from there
GuessOf guess_between(std::span<const PathSubmap> submaps, std::size_t relative_to,
                      std::size_t path, std::vector<SE3> T_common_odom,
                      const geometry::Vec3& start_m, double sigma_m, double sigma_rad) {
  return [=, T_common_odom = std::move(T_common_odom)](
             std::size_t target, std::size_t source) -> std::optional<places::Guess> {
    const PathSubmap& t = submaps[target];
    const PathSubmap& s = submaps[source];
    const bool between =
        (t.path == relative_to && s.path == path) || (t.path == path && s.path == relative_to);
    if (!between) return std::nullopt;
    const SE3 T_common_target = T_common_odom[t.path] * t.T_odom_ref;
    const SE3 T_common_source = T_common_odom[s.path] * s.T_odom_ref;
    places::Guess guess;
    guess.T_target_source = T_common_target.inverse() * T_common_source;
    const double path_m = t.path_m + s.path_m;
    const double turn = sigma_rad + kTurnPerMetre_rad * path_m;
    const SE3& T_swung = t.path == path ? T_common_target : T_common_source;
    const double lever_m = (T_swung.p - start_m).norm();
    const double place = sigma_m + turn * lever_m + kDriftPerMetre * path_m;
    guess.covariance.setZero();
    guess.covariance.diagonal().head<3>().setConstant(turn * turn);
    guess.covariance.diagonal().tail<3>().setConstant(place * place);
    return guess;
  };
}

}  // namespace

GuessOf guess_from_start(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                         std::size_t relative_to, std::size_t path, const SE3& T_relative_path,
                         double sigma_m, double sigma_rad) {
  // Both submaps in the level frame of the one that the start is relative to.
  std::vector<SE3> T_common_odom(paths.size());
  T_common_odom[relative_to] = T_map_odom_alone(paths[relative_to]);
  T_common_odom[path] = T_relative_path * T_map_odom_alone(paths[path]);
  return guess_between(submaps, relative_to, path, std::move(T_common_odom), T_relative_path.p,
                       sigma_m, sigma_rad);
}

GuessOf guess_from_frames(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                          std::size_t relative_to, std::size_t path, const YawPose& T_relative_path,
                          double sigma_m, double sigma_rad) {
  std::vector<SE3> T_common_odom(paths.size());
  T_common_odom[relative_to] = T_level_odom(paths[relative_to]);
  T_common_odom[path] = T_relative_path.se3() * T_level_odom(paths[path]);
  return guess_between(submaps, relative_to, path, std::move(T_common_odom), T_relative_path.t_m,
                       sigma_m, sigma_rad);
}

geometry::Mat6 with_bend(const geometry::Mat6& information, const geometry::Mat3& place_m2,
                         double bend_per_m, double apart_m) {
  using geometry::Mat3;
  using geometry::Mat6;
  constexpr double kMin_m2 = 1e-10;  // keeps it regular: 0.01 mm
  const Mat3 before_m2 = place_m2 + kMin_m2 * Mat3::Identity();
  const Mat3 left_m2 = (place_known(information) + before_m2.inverse()).inverse();
  const double all_m2 = left_m2.trace();
  Mat6 blur = Mat6::Zero();
  blur.topLeftCorner<3, 3>() = all_m2 * Mat3::Identity();
  blur.bottomRightCorner<3, 3>() =
      (1.0 + apart_m * apart_m) * (all_m2 * Mat3::Identity() - left_m2);
  return with_error<Mat6>(information, bend_per_m * bend_per_m * blur);
}

Loop loop_of(std::span<const PathSubmap> submaps, const LoopFound& found, double bend_per_m) {
  const PathSubmap& target = submaps[found.candidate.target];
  const PathSubmap& source = submaps[found.candidate.source];
  const places::Placement& best = found.recognition.placements.front();
  const places::BodyRelation relation =
      places::between_bodies(best.registration, target.submap, source.submap);
  Loop loop;
  loop.from = target.submap.middle();
  loop.to = source.submap.middle();
  loop.T_from_to = relation.T_target_source;
  const geometry::Mat3 R_body_ref = target.submap.T_ref_body().R.transpose();
  const geometry::Mat3 place_m2 =
      found.candidate.guess
          ? geometry::Mat3(found.candidate.guess->covariance.bottomRightCorner<3, 3>())
          : geometry::Mat3(kUnknown_m * kUnknown_m * geometry::Mat3::Identity());
  loop.information = with_bend(relation.information, R_body_ref * place_m2 * R_body_ref.transpose(),
                               bend_per_m, relation.T_target_source.p.norm());
  loop.overlap = best.verdict.overlap();
  loop.rms_m = best.registration.rms_m;
  return loop;
}

double slide_m(const geometry::Mat6& information, const geometry::Vec3& shift_m) {
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver(place_known(information));
  double squared_m2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (solver.eigenvalues()[k] * kUnknown_m * kUnknown_m > 1.0) continue;
    const double along_m = solver.eigenvectors().col(k).dot(shift_m);
    squared_m2 += along_m * along_m;
  }
  return std::sqrt(squared_m2);
}

}  // namespace rali::fleet
