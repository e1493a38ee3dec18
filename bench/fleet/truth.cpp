#include "truth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace rali::fleet_bench {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kKnown_m = 0.3;
constexpr double kKnown_rad = 3.0 * std::numbers::pi / 180.0;

/// Information on three of the six parameters, with the other three marginalised.
Mat3 loop_marginal(const geometry::Mat6& information, int first) {
  constexpr double kMin = 1e-9;  // keeps unobservable directions invertible
  const int other = 3 - first;
  const Mat3 out = information.block<3, 3>(other, other) + kMin * Mat3::Identity();
  const Mat3 cross = information.block<3, 3>(other, first);
  return information.block<3, 3>(first, first) - cross.transpose() * out.ldlt().solve(cross);
}

/// Norm of the error along the directions in which the information gives a sigma below `sigma`.
double known_part(const Vec3& error, const Mat3& information, double sigma) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(information);
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (solver.eigenvalues()[k] < 1.0 / (sigma * sigma)) continue;
    const double along = solver.eigenvectors().col(k).dot(error);
    sum += along * along;
  }
  return std::sqrt(sum);
}

const drive::KeyframeRecord& nearest(const std::vector<drive::KeyframeRecord>& keyframes, Time t) {
  return *std::min_element(keyframes.begin(), keyframes.end(), [t](const auto& a, const auto& b) {
    return std::abs(seconds_between(t, a.t)) < std::abs(seconds_between(t, b.t));
  });
}

}  // namespace

std::optional<SE3> truth_at(const Mission& mission, VehicleId vehicle, Time t) {
  const eval::PoseList& truth = mission.vehicles[vehicle.value].truth;
  const auto at = std::lower_bound(truth.begin(), truth.end(), t,
                                   [](const eval::StampedPose& p, Time x) { return p.t < x; });
  if (at == truth.end() || at->t != t) return std::nullopt;
  return at->T;
}

eval::PairList pairs_of(const Driven& driven, const Path& path) {
  eval::PairList pairs;
  std::size_t k = 0;
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const drive::PoseRecord& pose = path.poses[i];
    while (k < driven.truth.size() && driven.truth[k].t < pose.t) ++k;
    const bool lost = pose.quality == vehicle::PoseQuality::kDiverged;
    if (k == driven.truth.size() || driven.truth[k].t != pose.t || lost) continue;
    eval::PosePair pair;
    pair.t = pose.t;
    pair.est = path.T_map_odom * pose.T_odom_body;
    pair.ref = driven.truth[k].T;
    pair.est_index = i;
    pairs.push_back(pair);
  }
  return pairs;
}

std::optional<FrameError> frame_error(const Mission& mission, const Joined& joined, std::size_t a,
                                      std::size_t b, bool halves) {
  const auto& keyframes_a = joined.paths[a].keyframes;
  const auto& keyframes_b = joined.paths[b].keyframes;
  if (keyframes_a.empty() || keyframes_b.empty()) return std::nullopt;
  const Time t = keyframes_b.front().t;
  const Time t_middle =
      t + Duration::from_s(0.5 * std::max(0.0, seconds_between(t, keyframes_a.back().t)));
  const auto& k_a = halves ? nearest(keyframes_a, t_middle) : keyframes_a.front();
  const auto& k_b = halves ? nearest(keyframes_b, t_middle) : keyframes_b.front();
  const auto Q_a = truth_at(mission, k_a.id.vehicle, k_a.t);
  const auto Q_b = truth_at(mission, k_b.id.vehicle, k_b.t);
  if (!Q_a || !Q_b) return std::nullopt;
  const SE3 P_a = joined.paths[a].T_map_odom * k_a.T_local_body;
  const SE3 P_b = joined.paths[b].T_map_odom * k_b.T_local_body;
  const SE3 E = (Q_a->inverse() * *Q_b).inverse() * (P_a.inverse() * P_b);
  return FrameError{E.p.norm(), geometry::so3_log(E.R).norm()};
}

std::optional<FrameError> loop_error(const Mission& mission, const fleet::LoopVerdict& loop) {
  const auto Q_from = truth_at(mission, loop.from.vehicle, loop.t_from);
  const auto Q_to = truth_at(mission, loop.to.vehicle, loop.t_to);
  if (!Q_from || !Q_to) return std::nullopt;
  const SE3 truth = Q_from->inverse() * *Q_to;
  // Rotation in `to`, translation in `from`, as for the information.
  const Vec3 turn = geometry::so3_log(truth.R.transpose() * loop.T_from_to.R);
  const Vec3 shift = loop.T_from_to.p - truth.p;
  // Marginal of the position over the rotation, and of the rotation over the position.
  return FrameError{known_part(shift, loop_marginal(loop.information, 3), kKnown_m),
                    known_part(turn, loop_marginal(loop.information, 0), kKnown_rad)};
}

}  // namespace rali::fleet_bench
