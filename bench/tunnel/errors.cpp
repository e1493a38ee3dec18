#include "errors.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace rali::tunnel {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kChord_m = 0.5;  // ahead and behind

/// Direction of travel at each pair: a chord of one metre of the true path.
std::vector<Vec3> directions(const eval::PairList& pairs) {
  std::vector<Vec3> out(pairs.size(), Vec3::UnitX());
  std::size_t behind = 0;
  std::size_t ahead = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto far = [&](std::size_t k) { return (pairs[k].ref.p - pairs[i].ref.p).norm(); };
    while (behind + 1 < i && far(behind + 1) >= kChord_m) ++behind;
    ahead = std::max(ahead, i);
    while (ahead + 1 < pairs.size() && far(ahead) < kChord_m) ++ahead;
    const Vec3 chord = pairs[ahead].ref.p - pairs[behind].ref.p;
    // At standstill at the very start: the heading.
    out[i] = chord.norm() > 0.1 * kChord_m ? chord.normalized() : Vec3(pairs[i].ref.R.col(0));
  }
  return out;
}

}  // namespace

Result<Judged> judge(const std::vector<drive::PoseRecord>& poses, const eval::PoseList& truth,
                     Time t_end) {
  eval::PoseList est;
  Judged judged;
  for (const drive::PoseRecord& p : poses) {
    if (p.t > t_end) break;
    est.push_back({p.t, p.T_odom_body});
    judged.covariances.push_back(p.covariance);
  }
  auto matched = eval::associate(est, truth, {eval::AssociationMode::kNearest, 0.001, 0.0});
  if (!matched) return tl::make_unexpected(matched.error());
  judged.pairs = std::move(matched->pairs);
  judged.ahead = directions(judged.pairs);
  return judged;
}

AxisErrors axis_errors(const Judged& judged, const SE3& T_ref_est) {
  AxisErrors out;
  for (std::size_t i = 0; i < judged.pairs.size(); ++i) {
    const eval::PosePair& pair = judged.pairs[i];
    const Vec3 error = T_ref_est * pair.est.p - pair.ref.p;
    const Vec3 left = Vec3::UnitZ().cross(judged.ahead[i]).normalized();
    out.axial.push_back(judged.ahead[i].dot(error));
    out.lateral.push_back(left.dot(error));
    out.vertical.push_back(judged.ahead[i].cross(left).dot(error));
  }
  return out;
}

SE3 best_alignment(const Judged& judged) {
  const auto T = eval::align(judged.pairs, eval::Alignment::kSe3);
  return T ? *T : start_alignment(judged);
}

SE3 start_alignment(const Judged& judged) {
  return judged.pairs.front().ref * judged.pairs.front().est.inverse();
}

std::size_t pair_after(const eval::PairList& pairs, double after_s) {
  std::size_t i = 0;
  while (i + 1 < pairs.size() && seconds_between(pairs.front().t, pairs[i].t) < after_s) ++i;
  return i;
}

std::vector<double> axial_sigmas(const Judged& judged, std::size_t anchor) {
  const SE3 T_est_ref = judged.pairs[anchor].est * judged.pairs[anchor].ref.inverse();
  std::vector<double> out;
  for (std::size_t i = 0; i < judged.pairs.size(); ++i) {
    const Vec3 d = T_est_ref.R * judged.ahead[i];
    const geometry::Mat6& P = judged.covariances[judged.pairs[i].est_index];
    out.push_back(std::sqrt(std::max(0.0, d.dot(P.bottomRightCorner<3, 3>() * d))));
  }
  return out;
}

}  // namespace rali::tunnel
