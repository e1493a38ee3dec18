#include "rali/drive/output/corrected_path.hpp"

#include <algorithm>
#include <cstddef>

#include <Eigen/Eigenvalues>

#include "rali/geometry/so3.hpp"

namespace rali::drive {
namespace {

using geometry::Mat6;
using geometry::SE3;

/// Shorter ways are noise of standing.
constexpr double kWayMin_m = 1e-3;

/// A keyframe that carries the poses around it.
struct Knot {
  Time t;
  double way_m = 0.0;
  SE3 T_corrected_told;  ///< of odom: takes a told pose to where this keyframe sees it now
  Mat6 covariance = Mat6::Zero();
  Mat6 covariance_told = Mat6::Zero();
  bool corrected = false;
};

SE3 mixed(const SE3& a, const SE3& b, double share) {
  SE3 T;
  T.R = a.R * geometry::so3_exp(share * geometry::so3_log(a.R.transpose() * b.R));
  T.p = (1.0 - share) * a.p + share * b.p;
  return T;
}

bool is_lost(const PoseRecord& pose) { return pose.quality == vehicle::PoseQuality::kDiverged; }

/// Way from the first pose to each; steps into and out of diverged stretches are none.
std::vector<double> ways(const std::vector<PoseRecord>& poses) {
  std::vector<double> way_m(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const bool step = !is_lost(poses[i - 1]) && !is_lost(poses[i]);
    way_m[i] = way_m[i - 1];
    if (step) way_m[i] += (poses[i].T_local_body.p - poses[i - 1].T_local_body.p).norm();
  }
  return way_m;
}

double way_at(Time t, const std::vector<PoseRecord>& poses, const std::vector<double>& way_m) {
  const auto pose = std::lower_bound(poses.begin(), poses.end(), t,
                                     [](const PoseRecord& p, Time at) { return p.t < at; });
  if (way_m.empty()) return 0.0;
  return pose == poses.end() ? way_m.back() : way_m[static_cast<std::size_t>(pose - poses.begin())];
}

/// Moves the keyframes; returns them as knots.
std::vector<Knot> move_keyframes(const KeyframeCorrections& corrections,
                                 const std::vector<PoseRecord>& poses,
                                 std::vector<KeyframeRecord>& keyframes) {
  const std::vector<double> way_m = ways(poses);
  std::vector<Knot> knots;
  for (KeyframeRecord& keyframe : keyframes) {
    if (keyframe.diverged) continue;
    Knot knot;
    knot.t = keyframe.t;
    knot.way_m = way_at(keyframe.t, poses, way_m);
    const auto said = corrections.find(keyframe.id.seq);
    if (said != corrections.end()) {
      knot.T_corrected_told = said->second.T_local_body * keyframe.T_local_body.inverse();
      knot.covariance = said->second.covariance;
      knot.covariance_told = keyframe.covariance;
      knot.corrected = true;
      keyframe.T_local_body = said->second.T_local_body;
      keyframe.covariance = said->second.covariance;
    }
    knots.push_back(knot);
  }
  return knots;
}

/// How far a pose is from knot a on the way to knot b, 0 to 1.
double share_of(Time t, double way_m, const Knot& a, const Knot& b) {
  const double whole_m = b.way_m - a.way_m;
  if (whole_m > kWayMin_m) return std::clamp((way_m - a.way_m) / whole_m, 0.0, 1.0);
  const double whole_s = seconds_between(a.t, b.t);
  return whole_s > 0.0 ? std::clamp(seconds_between(a.t, t) / whole_s, 0.0, 1.0) : 0.0;
}

/// Of a pose that only one knot carries: what is known of the knot, and as much doubt as the
/// odometry has gathered between the two. The odometry's own doubt alone knows nothing of what the
/// whole map is wrong by: whoever stood for minutes after its last keyframe stated a third of it.
Mat6 carried(const Knot& knot, const PoseRecord& pose) {
  const Eigen::SelfAdjointEigenSolver<Mat6> grown(pose.covariance - knot.covariance_told);
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
  const std::vector<double> way_m = ways(poses);
  std::size_t after = 0;  // the first knot behind the pose
  for (std::size_t i = 0; i < poses.size(); ++i) {
    PoseRecord& pose = poses[i];
    while (after < knots.size() && knots[after].t <= pose.t) ++after;
    const Knot& a = knots[after == 0 ? 0 : after - 1];
    const Knot& b = knots[after == knots.size() ? after - 1 : after];
    const SE3 told = pose.T_local_body;
    if (&a == &b) {
      if (!a.corrected) continue;
      pose.T_local_body = a.T_corrected_told * told;
      pose.covariance = carried(a, pose);
      continue;
    }
    if (!a.corrected && !b.corrected) continue;
    const double share = share_of(pose.t, way_m[i], a, b);
    pose.T_local_body = mixed(a.T_corrected_told * told, b.T_corrected_told * told, share);
    if (a.corrected && b.corrected) {
      pose.covariance = (1.0 - share) * a.covariance + share * b.covariance;
    }
  }
}

}  // namespace rali::drive
