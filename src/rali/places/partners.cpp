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
      const double r = t.n.dot(d);
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
      const double r = t.n.dot(x - t.q_m);
      const double sigma = std::sqrt(t.variance_at(x) + s.var_offset +
                                     settings_.rough_sigma_m * settings_.rough_sigma_m);
      if (std::abs(r) > std::max(settings_.gate_min_m, settings_.gate_sigma * sigma)) continue;
    }
    pairs_.push_back({partner, i});
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return a.target != b.target ? a.target < b.target : a.source < b.source;
  });
}

double Partners::weight(double r, double variance_m2, const Plane& source) const {
  const double rough = settings_.rough_sigma_m * settings_.rough_sigma_m;
  if (!gate_.fine) {
    const double scale = gate_.distance_m / 3.0;
    return geometry::cauchy_weight(r / scale, 1.0) / (scale * scale);
  }
  const double s2 = source.var_offset + rough;
  return geometry::cauchy_weight(r / std::sqrt(s2 + variance_m2), settings_.cauchy_scale) / s2;
}

/// All pairs with one plane of the target share its three errors (algorithms 2.4):
/// I = HH - HA (Spl^-1 + AA)^-1 HA^T.
void Partners::add_plane(std::span<const Pair> pairs, const Plane& plane, const SE3& T,
                         System& system) {
  geometry::Mat6 HH = geometry::Mat6::Zero();
  Eigen::Matrix<double, 6, 3> HA = Eigen::Matrix<double, 6, 3>::Zero();
  Mat3 AA = Mat3::Zero();
  Vec6 Hr = Vec6::Zero();
  Vec3 Ar = Vec3::Zero();
  Vec3 lever = Vec3::Zero();
  double sum = 0.0;
  const Vec3 m = T.R.transpose() * plane.n;
  for (const Pair& pair : pairs) {
    const Plane& s = source_[pair.source];
    const Vec3 x = T * s.q_m;
    const Vec3 d = x - plane.q_m;
    const double r = plane.n.dot(d);
    const double w = weight(r, plane.variance_at(x), s);
    Vec6 H;
    H << s.q_m.cross(m), plane.n;
    const Vec3 A(plane.e1.dot(d), plane.e2.dot(d), -1.0);
    HH.noalias() += w * H * H.transpose();
    HA.noalias() += w * H * A.transpose();
    AA.noalias() += w * A * A.transpose();
    Hr += w * r * H;
    Ar += w * r * A;
    lever += w * (T.R * s.q_m);
    sum += w;
    ++system.matches;
    const double robust =
        w * (gate_.fine ? s.var_offset + settings_.rough_sigma_m * settings_.rough_sigma_m : 1.0);
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
  e.n_odom = plane.n;
  e.lever_odom_m = lever / sum;
  e.normal_covariance = plane.var_tilt1 * plane.e1 * plane.e1.transpose() +
                        plane.var_tilt2 * plane.e2 * plane.e2.transpose();
  e.weight = 1.0 / (1.0 / sum + plane.var_offset);
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
