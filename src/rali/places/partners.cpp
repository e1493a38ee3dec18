#include "rali/places/partners.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rali/geometry/robust.hpp"
#include "rali/places/align.hpp"

namespace rali::places {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

/// Weight of the lateral distance of a partner; the distance along the normal counts fully.
constexpr double kLateral = 0.1;

}  // namespace

void Partners::set_source(std::span<const Plane> planes, int maximum) {
  const std::size_t stride =
      (planes.size() - 1) / static_cast<std::size_t>(std::max(1, maximum)) + 1;
  source_.clear();
  for (std::size_t i = 0; i < planes.size(); i += stride) source_.push_back(planes[i]);
}

void Partners::find(const Submap& target, const SE3& T, const Gate& gate) {
  gate_ = gate;
  pairs_.clear();
  const double cos_min = std::cos(settings_.normal_deg * std::numbers::pi / 180.0);
  const std::span<const Plane> planes = target.planes();
  for (std::uint32_t i = 0; i < source_.size(); ++i) {
    const Plane& s = source_[i];
    const Vec3 x = T * s.q_m;
    const Vec3 n = T.R * s.n;
    double best = gate.search_m * gate.search_m;
    std::uint32_t partner = 0;
    bool found = false;
    target.plane_index().near(x, gate.search_m, [&](std::uint32_t k) {
      const Plane& t = planes[k];
      if (n.dot(t.n) < cos_min) return;
      const Vec3 d = x - t.q_m;
      const double r = 0.5 * (t.n + n).dot(d);
      const double lateral2 = d.squaredNorm() - r * r;
      const double reach = t.radius_m + (gate.fine ? 0.0 : gate.search_m);
      if (std::abs(r) > gate.distance_m || lateral2 > reach * reach) return;
      const double cost = r * r + kLateral * lateral2;
      if (cost >= best) return;
      best = cost;
      partner = k;
      found = true;
    });
    if (!found) continue;
    if (gate.fine) {
      const Plane& t = planes[partner];
      const Vec3 d = x - t.q_m;
      const double r = 0.5 * (t.n + n).dot(d);
      const double sigma =
          std::sqrt(t.var_offset + s.var_offset + rough2() +
                    0.25 * (t.tilt_variance_at(d) + s.tilt_variance_at(T.R.transpose() * d)));
      if (std::abs(r) > std::max(settings_.gate_min_m, settings_.gate_sigma * sigma)) continue;
    }
    pairs_.push_back({partner, i});
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return a.target != b.target ? a.target < b.target : a.source < b.source;
  });
}

double Partners::rough2() const { return settings_.rough_sigma_m * settings_.rough_sigma_m; }

/// @param of_target_m2, of_source_m2 variances of the residual; only the first is shared by its
/// pairs
double Partners::weight(double r, double of_target_m2, double of_source_m2) const {
  if (!gate_.fine) {
    const double scale = gate_.distance_m / 3.0;
    return geometry::cauchy_weight(r / scale, 1.0) / (scale * scale);
  }
  const double s2 = of_source_m2 + rough2();
  return geometry::cauchy_weight(r / std::sqrt(s2 + of_target_m2), settings_.cauchy_scale) / s2;
}

/// All pairs with one plane of the target share its three errors (algorithms 2.4):
/// I = HH - HA (Spl^-1 + AA)^-1 HA^T. The residual is symmetric in both planes (Rusinkiewicz 2019),
/// r = d.(n_t + n_s)/2: zero wherever both lie on one circle or sphere, so that a bent surface that
/// slides along itself gives no information. With the normal of one plane alone, roll in a round
/// pipe would be determined by the distances between neighbouring means.
void Partners::add_plane(std::span<const Pair> pairs, const Plane& plane, const SE3& T,
                         System& system) {
  geometry::Mat6 HH = geometry::Mat6::Zero();
  Eigen::Matrix<double, 6, 3> HA = Eigen::Matrix<double, 6, 3>::Zero();
  Mat3 AA = Mat3::Zero();
  Vec6 Hr = Vec6::Zero();
  Vec3 Ar = Vec3::Zero();
  Vec3 lever = Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  Mat3 tilt = Mat3::Zero();  // of the source's planes, in its axes
  double sum = 0.0;
  double residual_sum = 0.0;
  const Vec3 q = plane.q_m - T.p;
  for (const Pair& pair : pairs) {
    const Plane& s = source_[pair.source];
    const Vec3 x = T.R * s.q_m;
    const Vec3 n_s = T.R * s.n;
    const Vec3 d = x - q;
    const Vec3 n = 0.5 * (plane.n + n_s);
    const double r = n.dot(d);
    const double of_source = 0.25 * s.tilt_variance_at(T.R.transpose() * d);
    const double w =
        weight(r, plane.var_offset + 0.25 * plane.tilt_variance_at(d), s.var_offset + of_source);
    Vec6 H;
    H << T.R.transpose() * (0.5 * (x.cross(plane.n) + q.cross(n_s))), n;
    const Vec3 A(0.5 * plane.e1.dot(d), 0.5 * plane.e2.dot(d), -1.0);
    HH.noalias() += w * H * H.transpose();
    HA.noalias() += w * H * A.transpose();
    AA.noalias() += w * A * A.transpose();
    Hr += w * r * H;
    Ar += w * r * A;
    lever += w * 0.5 * (x + q);
    normal += w * n;
    tilt += w * s.normal_covariance();
    sum += w;
    residual_sum += w * r;
    ++system.matches;
    const double robust = w * (gate_.fine ? s.var_offset + of_source + rough2() : 1.0);
    system.square_sum_m2 += robust * r * r;
    system.weight_sum += robust;
  }
  if (gate_.fine) {
    AA.diagonal() += Vec3(1.0 / plane.var_tilt1, 1.0 / plane.var_tilt2, 1.0 / plane.var_offset);
    const Eigen::Matrix<double, 6, 3> K = HA * AA.inverse();
    HH.noalias() -= K * HA.transpose();
    Hr.noalias() -= K * Ar;
  }
  system.I += HH;
  system.b += Hr;
  degeneracy::PlaneEvidence e;
  e.n_odom = normal.normalized();
  e.lever_odom_m = lever / sum;
  e.normal_covariance = 0.25 * (plane.normal_covariance() + T.R * (tilt / sum) * T.R.transpose());
  e.weight = 1.0 / (1.0 / sum + plane.var_offset);
  e.residual_m = residual_sum / sum;
  e.points = static_cast<int>(pairs.size());
  evidence_.push_back(e);
}

System Partners::accumulate(const Submap& target, const SE3& T) {
  System system;
  evidence_.clear();
  for (std::size_t b = 0; b < pairs_.size();) {
    std::size_t e = b + 1;
    while (e < pairs_.size() && pairs_[e].target == pairs_[b].target) ++e;
    add_plane(std::span<const Pair>(pairs_).subspan(b, e - b), target.planes()[pairs_[b].target], T,
              system);
    b = e;
  }
  return system;
}

}  // namespace rali::places
