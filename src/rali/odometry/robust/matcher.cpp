#include "rali/odometry/robust/matcher.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "rali/degeneracy/support.hpp"
#include "rali/geometry/robust.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::skew;
using geometry::Vec3;
using geometry::Vec6;

namespace {

/// Variance of the plane's height at x: offset and the two tilts (A Spl A^T of algorithms 2.4).
double plane_variance_at(const Plane& plane, const Vec3& x_minus_q) {
  const double a1 = plane.e1.dot(x_minus_q);
  const double a2 = plane.e2.dot(x_minus_q);
  return plane.var_offset + a1 * a1 * plane.var_tilt1 + a2 * a2 * plane.var_tilt2;
}

bool faces(const Plane& plane, const Vec3& d_odom) {
  const double a1 = plane.e1.dot(d_odom);
  const double a2 = plane.e2.dot(d_odom);
  return degeneracy::faces(plane.n.dot(d_odom),
                           a1 * a1 * plane.var_tilt1 + a2 * a2 * plane.var_tilt2);
}

}  // namespace

void Matcher::set_points(const BodyPoints& points, const Vec3& p_body_lidar) {
  points_.resize(points.size());
  const Eigen::Vector3f origin = p_body_lidar.cast<float>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Point& p = points_[i];
    p.x = points.x_m[i];
    p.y = points.y_m[i];
    p.z = points.z_m[i];
    const float rx = p.x - origin.x();
    const float ry = p.y - origin.y();
    const float rz = p.z - origin.z();
    const float range2 = rx * rx + ry * ry + rz * rz;
    const float inverse = range2 > 1e-8F ? 1.0F / std::sqrt(range2) : 0.0F;
    p.dx = rx * inverse;
    p.dy = ry * inverse;
    p.dz = rz * inverse;
    p.range2_m2 = range2;
    p.plane = -1;
  }
}

double Matcher::point_variance(const Point& p, double cos_incidence, double plane_var_m2) const {
  const double c2 = cos_incidence * cos_incidence;
  const double beam = settings_.beam_sigma_rad;
  const double model = c2 * settings_.range_sigma_m * settings_.range_sigma_m +
                       (1.0 - c2) * beam * beam * static_cast<double>(p.range2_m2) +
                       settings_.rough_sigma_m * settings_.rough_sigma_m;
  return std::max(model, plane_var_m2);
}

void Matcher::match(const PlaneMap& map, const SE3& T_odom_body, const Mat6& P_pose, Reach reach) {
  const Mat3& R = T_odom_body.R;
  for (Point& point : points_) {
    const Vec3 p_body = point.p_body();
    const Vec3 x = R * p_body + T_odom_body.p;
    point.plane = reach == Reach::kNear ? map.find_near(x) : map.find(x);
    if (point.plane < 0) continue;
    const Plane& plane = map.plane(point.plane);
    const Vec3 d = x - plane.q;
    if (reach == Reach::kPoints && !plane.reaches(d)) {
      point.plane = -1;
      continue;
    }
    const double r = plane.n.dot(d);
    // Most points are so near that they match for any gate, whose computation is the costliest
    // part.
    if (!(std::abs(r) > settings_.gate_min_m)) continue;
    const Vec3 m = R.transpose() * plane.n;
    Vec6 H;
    H << p_body.cross(m), plane.n;
    const double cos_incidence = m.dot(point.ray_body());
    const double variance = point_variance(point, cos_incidence, plane.var_normal) +
                            plane_variance_at(plane, d) + H.dot(P_pose * H);
    const double gate = std::clamp(settings_.gate_sigma * std::sqrt(variance), settings_.gate_min_m,
                                   settings_.gate_max_m);
    if (std::abs(r) > gate) point.plane = -1;
  }
}

Overlap Matcher::overlap(const PlaneMap& map, const SE3& T_odom_body) const {
  Overlap out;
  for (const Point& point : points_) {
    const Vec3 x = T_odom_body.R * point.p_body() + T_odom_body.p;
    const int index = map.find(x);
    if (index < 0) continue;
    const Plane& plane = map.plane(index);
    const Vec3 d = x - plane.q;
    if (!plane.reaches(d)) continue;
    ++out.within;
    if (std::abs(plane.n.dot(d)) < settings_.gate_min_m) ++out.on;
  }
  return out;
}

LidarSystem Matcher::accumulate(const PlaneMap& map, const SE3& T_odom_body) {
  LidarSystem system;
  groups_.clear();
  evidence_.clear();
  epochs_.clear();
  group_of_plane_.resize(std::max(group_of_plane_.size(), map.plane_count()), -1);
  const Mat3& R = T_odom_body.R;
  for (const Point& point : points_) {
    if (point.plane < 0) continue;
    int& g = group_of_plane_[static_cast<std::size_t>(point.plane)];
    if (g < 0) {
      g = static_cast<int>(groups_.size());
      groups_.push_back(Group{point.plane, 0, {}});
    }
    Group& group = groups_[static_cast<std::size_t>(g)];
    const Plane& plane = map.plane(point.plane);
    const Vec3 p = point.p_body();
    const Vec3 d = R * p + T_odom_body.p - plane.q;
    const double r = plane.n.dot(d);
    const Vec3 ray = point.ray_body();
    const double cos_incidence = plane.n.dot(R * ray);
    const double s2 = point_variance(point, cos_incidence, plane.var_normal);
    const double scale = std::sqrt(s2 + plane_variance_at(plane, d));
    const double robust = geometry::cauchy_weight(r / scale, settings_.cauchy_scale);
    const double w = robust / s2;
    double* m = group.m;
    m[0] += w * p.x() * p.x();
    m[1] += w * p.x() * p.y();
    m[2] += w * p.x() * p.z();
    m[3] += w * p.x();
    m[4] += w * p.y() * p.y();
    m[5] += w * p.y() * p.z();
    m[6] += w * p.y();
    m[7] += w * p.z() * p.z();
    m[8] += w * p.z();
    m[9] += w;
    ++group.points;
    ++system.matches;
    system.residual_sum2_m2 += robust * r * r;
    system.weight_sum += robust;
  }
  double epoch_sum = 0.0;
  double weight_sum = 0.0;
  for (const Group& group : groups_) {
    add_group(group, map, T_odom_body, system);
    group_of_plane_[static_cast<std::size_t>(group.plane)] = -1;
    epochs_.push_back(map.plane(group.plane).epoch);
    epoch_sum += evidence_.back().weight * epochs_.back();
    weight_sum += evidence_.back().weight;
  }
  if (weight_sum > 0.0) system.mean_epoch = epoch_sum / weight_sum;
  return system;
}

std::optional<double> Matcher::mean_epoch(const Vec3& d_odom) const {
  constexpr double kNormalSigmas = 2.0;
  double epoch_sum = 0.0;
  double weight_sum = 0.0;
  for (std::size_t k = 0; k < evidence_.size(); ++k) {
    const degeneracy::PlaneEvidence& plane = evidence_[k];
    const double along = d_odom.dot(plane.n_odom);
    const double noise = d_odom.dot(plane.normal_covariance * d_odom);
    const double fraction = along * along - kNormalSigmas * kNormalSigmas * noise;
    if (fraction <= 0.0) continue;
    epoch_sum += plane.weight * fraction * epochs_[k];
    weight_sum += plane.weight * fraction;
  }
  if (weight_sum <= 0.0) return std::nullopt;
  return epoch_sum / weight_sum;
}

/// Information of a point along d, if it lies on the plane.
double Matcher::hold_of(const Point& point, const Plane& plane, const Vec3& x_odom,
                        const Vec3& d_odom, const Vec3& ray_odom) const {
  const Vec3 d = x_odom - plane.q;
  const double along = plane.n.dot(d_odom);
  const double s2 =
      point_variance(point, plane.n.dot(ray_odom), plane.var_normal) + plane_variance_at(plane, d);
  const double r = plane.n.dot(d);
  const double gate = std::max(settings_.gate_sigma * std::sqrt(s2), settings_.gate_min_m);
  return std::abs(r) > gate ? 0.0 : along * along / s2;
}

Matcher::Match Matcher::match_of(const Point& point, const PlaneMap& map,
                                 const SE3& T_odom_body) const {
  const Plane& plane = map.plane(point.plane);
  const Vec3 d = T_odom_body.R * point.p_body() + T_odom_body.p - plane.q;
  Match out;
  out.n_body = T_odom_body.R.transpose() * plane.n;
  out.ray_body = point.ray_body();
  out.range_m = std::sqrt(static_cast<double>(point.range2_m2));
  out.residual_m = plane.n.dot(d);
  const double variance = point_variance(point, out.n_body.dot(out.ray_body), plane.var_normal) +
                          plane_variance_at(plane, d);
  out.weight =
      geometry::cauchy_weight(out.residual_m / std::sqrt(variance), settings_.cauchy_scale) /
      variance;
  out.epoch = plane.epoch;
  return out;
}

std::size_t Matcher::points_facing(const PlaneMap& map, const Vec3& d_odom) const {
  return static_cast<std::size_t>(
      std::count_if(points_.begin(), points_.end(), [&](const Point& point) {
        return point.plane >= 0 && faces(map.plane(point.plane), d_odom);
      }));
}

Hold Matcher::hold_along(const PlaneMap& map, const SE3& T_odom_body, const Vec3& d_odom,
                         double step_m, double newest_epoch) const {
  const auto hold = [&](const Point& point, int plane, const Vec3& x_odom) {
    if (plane < 0 || !(map.plane(plane).epoch < newest_epoch + 0.5)) return 0.0;
    if (!faces(map.plane(plane), d_odom)) return 0.0;
    return hold_of(point, map.plane(plane), x_odom, d_odom, T_odom_body.R * point.ray_body());
  };
  Hold out;
  double ahead = 0.0;
  double behind = 0.0;
  for (const Point& point : points_) {
    const Vec3 x = T_odom_body.R * point.p_body() + T_odom_body.p;
    const double here = hold(point, point.plane, x);
    if (!(here > 0.0)) continue;
    const Vec3 forward = x + step_m * d_odom;
    const Vec3 back = x - step_m * d_odom;
    out.here += here;
    ahead += hold(point, map.find(forward), forward);
    behind += hold(point, map.find(back), back);
  }
  out.elsewhere = std::max(ahead, behind);
  return out;
}

/// One point: its noise and the plane's at that position add up to one variance.
void Matcher::add_point(const Group& group, const PlaneInBody& plane, LidarSystem& system) {
  const double w = group.m[9];
  const Vec3 p = Vec3(group.m[3], group.m[6], group.m[8]) / w;
  const double a1 = plane.e1.dot(p) + plane.c1_m;
  const double a2 = plane.e2.dot(p) + plane.c2_m;
  const double variance =
      1.0 / w + plane.var_offset + a1 * a1 * plane.var_tilt1 + a2 * a2 * plane.var_tilt2;
  Vec6 h;
  h << p.cross(plane.n), plane.n_odom;
  const Vec6 weighted = h / variance;
  system.I.noalias() += weighted * h.transpose();
  system.b += (plane.n.dot(p) + plane.c_m) * weighted;
}

void Matcher::add_moments(const Group& group, const PlaneInBody& plane, LidarSystem& system) {
  // With p~ = [p; 1]: the Jacobian is H^T = L p~, the residual rho^T p~ and the influence of the
  // plane's three errors A^T = B p~, so the moments M = sum w p~ p~^T suffice. L = [-m^ 0; 0 n], B
  // = [e1 c1; e2 c2; 0 -1]; the zeros are not multiplied.
  const double* g = group.m;
  Mat3 P;
  P << g[0], g[1], g[2], g[1], g[4], g[5], g[2], g[5], g[7];
  const Vec3 s(g[3], g[6], g[8]);
  const double w = g[9];
  const Vec3& m = plane.n;

  // M B^T, column by column: three numbers and a fourth; the third column is -[s; w].
  const Vec3 u1 = P * plane.e1 + plane.c1_m * s;
  const Vec3 u2 = P * plane.e2 + plane.c2_m * s;
  const double w1 = s.dot(plane.e1) + plane.c1_m * w;
  const double w2 = s.dot(plane.e2) + plane.c2_m * w;
  const Vec3 um = P * m + plane.c_m * s;  // M rho
  const double wm = s.dot(m) + plane.c_m * w;

  Mat3 S;
  S(0, 0) = plane.e1.dot(u1) + plane.c1_m * w1 + 1.0 / plane.var_tilt1;
  S(0, 1) = S(1, 0) = plane.e1.dot(u2) + plane.c1_m * w2;
  S(0, 2) = S(2, 0) = -w1;
  S(1, 1) = plane.e2.dot(u2) + plane.c2_m * w2 + 1.0 / plane.var_tilt2;
  S(1, 2) = S(2, 1) = -w2;
  S(2, 2) = w + 1.0 / plane.var_offset;
  Eigen::Matrix<double, 6, 3> HA;
  HA << u1.cross(m), u2.cross(m), -s.cross(m), w1 * plane.n_odom, w2 * plane.n_odom,
      -w * plane.n_odom;
  const Vec3 A_rho(plane.e1.dot(um) + plane.c1_m * wm, plane.e2.dot(um) + plane.c2_m * wm, -wm);
  const Eigen::Matrix<double, 6, 3> K = HA * S.inverse();

  const Mat3 minus_skew = -skew(m);
  const Vec3 arm = s.cross(m);
  system.I.topLeftCorner<3, 3>() += minus_skew * P * minus_skew.transpose();
  system.I.topRightCorner<3, 3>() += arm * plane.n_odom.transpose();
  system.I.bottomLeftCorner<3, 3>() += plane.n_odom * arm.transpose();
  system.I.bottomRightCorner<3, 3>() += w * plane.n_odom * plane.n_odom.transpose();
  system.I.noalias() -= K * HA.transpose();
  system.b.head<3>() += um.cross(m);
  system.b.tail<3>() += wm * plane.n_odom;
  system.b.noalias() -= K * A_rho;
}

void Matcher::add_group(const Group& group, const PlaneMap& map, const SE3& T_odom_body,
                        LidarSystem& system) {
  const Plane& plane = map.plane(group.plane);
  const Mat3& R = T_odom_body.R;
  const Vec3 t = T_odom_body.p - plane.q;
  const double* g = group.m;
  const Vec3 center = Vec3(g[3], g[6], g[8]) / g[9];
  const PlaneInBody in_body{
      R.transpose() * plane.n, R.transpose() * plane.e1, R.transpose() * plane.e2, plane.n,
      plane.n.dot(t),          plane.e1.dot(t),          plane.e2.dot(t),          plane.var_tilt1,
      plane.var_tilt2,         plane.var_offset};
  if (group.points == 1) {
    add_point(group, in_body, system);
  } else {
    add_moments(group, in_body, system);
  }

  degeneracy::PlaneEvidence c;
  c.n_odom = plane.n;
  c.normal_covariance = plane.var_tilt1 * plane.e1 * plane.e1.transpose() +
                        plane.var_tilt2 * plane.e2 * plane.e2.transpose();
  c.weight = 1.0 / (1.0 / g[9] + plane.var_offset);
  c.lever_odom_m = R * center;
  c.points = group.points;
  c.residual_m = in_body.n.dot(center) + in_body.c_m;
  evidence_.push_back(c);
}

}  // namespace rali::odometry
