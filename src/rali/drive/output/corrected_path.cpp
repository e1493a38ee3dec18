#include "rali/drive/output/corrected_path.hpp"

#include <algorithm>
#include <cstddef>

#include <Eigen/Eigenvalues>

#include "rali/geometry/so3.hpp"

namespace rali::drive {
namespace {

using geometry::Mat6;
using geometry::SE3;

/// Shorter paths are noise at standstill.
constexpr double kPathMin_m = 1e-3;

/// A keyframe that corrects the poses around it.
struct Knot {
  Time t;
  double path_m = 0.0;
  SE3 T_corrected_reported;  ///< in odom: from a published pose to its correction by this keyframe
  Mat6 covariance = Mat6::Zero();
  Mat6 covariance_reported = Mat6::Zero();
  bool corrected = false;
};

SE3 mixed(const SE3& a, const SE3& b, double fraction) {
  SE3 T;
  T.R = a.R * geometry::so3_exp(fraction * geometry::so3_log(a.R.transpose() * b.R));
  T.p = (1.0 - fraction) * a.p + fraction * b.p;
  return T;
}

bool is_lost(const PoseRecord& pose) { return pose.quality == vehicle::PoseQuality::kDiverged; }

/// Distance travelled from the first pose to each; steps into and out of diverged stretches do not
/// count.
std::vector<double> paths(const std::vector<PoseRecord>& poses) {
  std::vector<double> path_m(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const bool step = !is_lost(poses[i - 1]) && !is_lost(poses[i]);
    path_m[i] = path_m[i - 1];
    if (step) path_m[i] += (poses[i].T_local_body.p - poses[i - 1].T_local_body.p).norm();
  }
  return path_m;
}

double path_at(Time t, const std::vector<PoseRecord>& poses, const std::vector<double>& path_m) {
  const auto pose = std::lower_bound(poses.begin(), poses.end(), t,
                                     [](const PoseRecord& p, Time at) { return p.t < at; });
  if (path_m.empty()) return 0.0;
  return pose == poses.end() ? path_m.back()
                             : path_m[static_cast<std::size_t>(pose - poses.begin())];
}

/// Moves the keyframes; returns them as knots.
std::vector<Knot> move_keyframes(const KeyframeCorrections& corrections,
                                 const std::vector<PoseRecord>& poses,
                                 std::vector<KeyframeRecord>& keyframes) {
  const std::vector<double> path_m = paths(poses);
  std::vector<Knot> knots;
  for (KeyframeRecord& keyframe : keyframes) {
    if (keyframe.diverged) continue;
    Knot knot;
    knot.t = keyframe.t;
    knot.path_m = path_at(keyframe.t, poses, path_m);
    const auto reported = corrections.find(keyframe.id.seq);
    if (reported != corrections.end()) {
      knot.T_corrected_reported = reported->second.T_local_body * keyframe.T_local_body.inverse();
      knot.covariance = reported->second.covariance;
      knot.covariance_reported = keyframe.covariance;
      knot.corrected = true;
      keyframe.T_local_body = reported->second.T_local_body;
      keyframe.covariance = reported->second.covariance;
    }
    knots.push_back(knot);
  }
  return knots;
}

/// Position of a pose between knots a and b along the path, 0 to 1.
double fraction_of(Time t, double path_m, const Knot& a, const Knot& b) {
  const double whole_m = b.path_m - a.path_m;
  if (whole_m > kPathMin_m) return std::clamp((path_m - a.path_m) / whole_m, 0.0, 1.0);
  const double whole_s = seconds_between(a.t, b.t);
  return whole_s > 0.0 ? std::clamp(seconds_between(a.t, t) / whole_s, 0.0, 1.0) : 0.0;
}

/// Covariance of a pose with only one neighbouring knot: the knot's, plus the odometry's growth
/// between the two. The odometry's covariance alone excludes the error of the map as a whole: a
/// vehicle at standstill for minutes after its last keyframe stated a third of it.
Mat6 carried(const Knot& knot, const PoseRecord& pose) {
  const Eigen::SelfAdjointEigenSolver<Mat6> grown(Mat6(pose.covariance - knot.covariance_reported));
  const geometry::Vec6 gathered = grown.eigenvalues().cwiseMax(0.0);
  return knot.covariance +
         grown.eigenvectors() * gathered.asDiagonal() * grown.eigenvectors().transpose();
}

}  // namespace

void correct_path(const KeyframeCorrections& corrections, std::vector<PoseRecord>& poses,
                  std::vector<KeyframeRecord>& keyframes) {
  if (corrections.empty()) return;
  const std::vector<Knot> knots = move_keyframes(corrections, poses, keyframes);
  if (knots.empty()) return;
  const std::vector<double> path_m = paths(poses);
  std::size_t after = 0;  // the first knot after the pose
  for (std::size_t i = 0; i < poses.size(); ++i) {
    PoseRecord& pose = poses[i];
    while (after < knots.size() && knots[after].t <= pose.t) ++after;
    const Knot& a = knots[after == 0 ? 0 : after - 1];
    const Knot& b = knots[after == knots.size() ? after - 1 : after];
    const SE3 reported = pose.T_local_body;
    if (&a == &b) {
      if (!a.corrected) continue;
      pose.T_local_body = a.T_corrected_reported * reported;
      pose.covariance = carried(a, pose);
      continue;
    }
    if (!a.corrected && !b.corrected) continue;
    const double fraction = fraction_of(pose.t, path_m[i], a, b);
    pose.T_local_body =
        mixed(a.T_corrected_reported * reported, b.T_corrected_reported * reported, fraction);
    if (a.corrected && b.corrected) {
      pose.covariance = (1.0 - fraction) * a.covariance + fraction * b.covariance;
    }
  }
}

}  // namespace rali::drive
