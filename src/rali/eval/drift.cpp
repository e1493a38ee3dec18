#include "rali/eval/drift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

namespace rali::eval {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// Least fraction of the velocities that a displacement of the trajectory does not explain: at
/// constant velocity a shift in time and one in space are the same.
constexpr double kVelocityLeft = 0.01;
/// Over longer spans a difference of positions is not a velocity.
constexpr double kVelocitySpan_s = 0.5;
constexpr double kLevelCosMin = 0.984807753;  // 10 degrees

PoseError relative_error(Time t, const SE3& Q, const SE3& P) {
  const SE3 E = Q.inverse() * P;
  return {t, E.p.norm(), geometry::so3_log(E.R).norm()};
}

}  // namespace

Drift drift(const PairList& pairs, const SE3& T_ref_est) {
  const PosePair& first = pairs.front();
  const PosePair& last = pairs.back();
  const PoseError e =
      relative_error(last.t, first.ref.inverse() * last.ref, first.est.inverse() * last.est);
  Drift out;
  out.final_m = e.translation_m;
  out.final_rad = e.rotation_rad;
  out.path_m = path_length_m(pairs);
  if (T_ref_est.R(2, 2) >= kLevelCosMin) {
    out.z_m = (last.est.p.z() - first.est.p.z()) - (last.ref.p.z() - first.ref.p.z());
  }
  return out;
}

std::vector<DegenerateError> degenerate_errors(const PairList& pairs, const SE3& T_ref_est,
                                               const std::vector<Vec3>& directions) {
  std::vector<DegenerateError> out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PosePair& p = pairs[i];
    if (p.est_index >= directions.size() || directions[p.est_index].isZero()) continue;
    const Vec3 axis_ref = T_ref_est.R * directions[p.est_index].normalized();
    const Vec3 e = T_ref_est * p.est.p - p.ref.p;
    const double along = axis_ref.dot(e);
    out.push_back({i, along, (e - along * axis_ref).norm()});
  }
  return out;
}

std::optional<TimeShift> time_shift(const PairList& pairs, const SE3& T_ref_est) {
  using Vec7 = Eigen::Matrix<double, 7, 1>;
  using Mat7 = Eigen::Matrix<double, 7, 7>;
  Vec3 middle = Vec3::Zero();
  for (const PosePair& pair : pairs) middle += pair.ref.p / static_cast<double>(pairs.size());
  // Unknowns: the time shift, and the displacement of the whole trajectory by which the alignment
  // has absorbed the shift: e = s v + c + w x (p - middle).
  Mat7 H = Mat7::Zero();
  Vec7 g = Vec7::Zero();
  double ee = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 1; i + 1 < pairs.size(); ++i) {
    const double dt = seconds_between(pairs[i - 1].t, pairs[i + 1].t);
    if (!(dt > 0.0) || dt > kVelocitySpan_s) continue;
    const Vec3 e = T_ref_est * pairs[i].est.p - pairs[i].ref.p;
    Eigen::Matrix<double, 3, 7> J;
    J.col(0) = (pairs[i + 1].ref.p - pairs[i - 1].ref.p) / dt;
    J.middleCols<3>(1).setIdentity();
    J.rightCols<3>() = -geometry::skew(pairs[i].ref.p - middle);
    H += J.transpose() * J;
    g += J.transpose() * e;
    ee += e.squaredNorm();
    ++n;
  }
  const double vv = H(0, 0);
  if (!(vv > 0.0)) return std::nullopt;
  // Eliminate the displacement first; the remainder of the velocities makes the shift observable.
  Eigen::Matrix<double, 6, 6> H_path = H.bottomRightCorner<6, 6>();
  H_path.diagonal().array() += 1e-9 * H_path.trace();  // roll is unobservable on straight paths
  const auto ldlt = H_path.ldlt();
  const Eigen::Matrix<double, 6, 1> path = ldlt.solve(g.tail<6>());
  const double left_vv = vv - H.col(0).tail<6>().dot(ldlt.solve(H.col(0).tail<6>()));
  if (!(left_vv > kVelocityLeft * vv)) return std::nullopt;
  const double left_ve = g(0) - H.col(0).tail<6>().dot(path);
  const double left_ee = std::max(0.0, ee - g.tail<6>().dot(path));
  const double count = static_cast<double>(n);
  TimeShift out;
  out.shift_s = left_ve / left_vv;
  out.rmse_m = std::sqrt(left_ee / count);
  out.rmse_after_m = std::sqrt(std::max(0.0, left_ee - left_ve * left_ve / left_vv) / count);
  return out;
}

std::vector<PoseError> errors_between(const PairList& a, const PairList& b, double max_gap_s) {
  PoseList b_est, b_ref;
  for (const PosePair& p : b) {
    if (!b_est.empty() && p.t <= b_est.back().t) continue;
    b_est.push_back({p.t, p.est});
    b_ref.push_back({p.t, p.ref});
  }
  std::vector<PoseError> out;
  for (const PosePair& p : a) {
    const auto P_b = pose_at(b_est, p.t, max_gap_s);
    const auto Q_b = pose_at(b_ref, p.t, max_gap_s);
    if (!P_b || !Q_b) continue;
    out.push_back(relative_error(p.t, p.ref.inverse() * *Q_b, p.est.inverse() * *P_b));
  }
  return out;
}

}  // namespace rali::eval
