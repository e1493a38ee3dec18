#include "rali/eval/drift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::eval {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// Longer than this a difference of positions is no velocity.
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
  out.way_m = way_length_m(pairs);
  if (T_ref_est.R(2, 2) >= kLevelCosMin) {
    out.z_m = (last.est.p.z() - first.est.p.z()) - (last.ref.p.z() - first.ref.p.z());
  }
  return out;
}

std::vector<BlindError> blind_errors(const PairList& pairs, const SE3& T_ref_est,
                                     const std::vector<Vec3>& directions) {
  std::vector<BlindError> out;
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
  double vv = 0.0, ve = 0.0, ee = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 1; i + 1 < pairs.size(); ++i) {
    const double dt = seconds_between(pairs[i - 1].t, pairs[i + 1].t);
    if (!(dt > 0.0) || dt > kVelocitySpan_s) continue;
    const Vec3 v = (pairs[i + 1].ref.p - pairs[i - 1].ref.p) / dt;
    const Vec3 e = T_ref_est * pairs[i].est.p - pairs[i].ref.p;
    vv += v.squaredNorm();
    ve += v.dot(e);
    ee += e.squaredNorm();
    ++n;
  }
  if (!(vv > 0.0)) return std::nullopt;
  const double count = static_cast<double>(n);
  TimeShift out;
  out.shift_s = ve / vv;
  out.rmse_m = std::sqrt(ee / count);
  out.rmse_after_m = std::sqrt(std::max(0.0, ee - ve * ve / vv) / count);
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
