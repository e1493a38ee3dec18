#include "rali/odometry/robust/matcher.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

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

}  // namespace

void Matcher::set_points(const BodyPoints& points, const Vec3& p_body_lidar) {
  points_.resize(points.size());
  const Eigen::Vector3f origin = p_body_lidar.cast<float>();
  const float beam = static_cast<float>(settings_.beam_sigma_rad);
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
    p.beam_var_m2 = range2 * beam * beam;
    p.plane = -1;
  }
}

double Matcher::point_variance(const Point& p, double cos_incidence, double plane_var_m2) const {
  const double c2 = cos_incidence * cos_incidence;
  const double model = c2 * settings_.range_sigma_m * settings_.range_sigma_m +
                       (1.0 - c2) * static_cast<double>(p.beam_var_m2) +
                       settings_.rough_sigma_m * settings_.rough_sigma_m;
  return std::max(model, plane_var_m2);
}

void Matcher::match(const PlaneMap& map, const SE3& T_odom_body, const Mat6& P_pose, bool wide) {
  const Mat3& R = T_odom_body.R;
  for (Point& point : points_) {
    const Vec3 p_body(point.x, point.y, point.z);
    const Vec3 x = R * p_body + T_odom_body.p;
    point.plane = wide ? map.find_near(x) : map.find(x);
    if (point.plane < 0) continue;
    const Plane& plane = map.plane(point.plane);
    const Vec3 d = x - plane.q;
    const double r = plane.n.dot(d);
    const Vec3 m = R.transpose() * plane.n;
    Vec6 H;
    H << p_body.cross(m), plane.n;
    const double cos_incidence = m.dot(Vec3(point.dx, point.dy, point.dz));
    const double variance = point_variance(point, cos_incidence, plane.var_normal) +
                            plane_variance_at(plane, d) + H.dot(P_pose * H);
    const double gate = std::clamp(settings_.gate_sigma * std::sqrt(variance), settings_.gate_min_m,
                                   settings_.gate_max_m);
    if (std::abs(r) > gate) point.plane = -1;
  }
}

LidarSystem Matcher::accumulate(const PlaneMap& map, const SE3& T_odom_body) {
  LidarSystem system;
  groups_.clear();
  evidence_.clear();
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
    const Vec3 p(point.x, point.y, point.z);
    const Vec3 d = R * p + T_odom_body.p - plane.q;
    const double r = plane.n.dot(d);
    const double cos_incidence = plane.n.dot(R * Vec3(point.dx, point.dy, point.dz));
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
    epoch_sum += evidence_.back().weight * map.plane(group.plane).epoch;
    weight_sum += evidence_.back().weight;
  }
  if (weight_sum > 0.0) system.mean_epoch = epoch_sum / weight_sum;
  return system;
}

void Matcher::add_group(const Group& group, const PlaneMap& map, const SE3& T_odom_body,
                        LidarSystem& system) {
  // With p~ = [p; 1]: the Jacobian is H^T = L p~, the residual rho^T p~ and the influence of the
  // plane's three errors A^T = B p~, so the moments M = sum w p~ p~^T are all that is needed.
  const Plane& plane = map.plane(group.plane);
  const Mat3& R = T_odom_body.R;
  const Vec3 m = R.transpose() * plane.n;
  const Vec3 t = T_odom_body.p - plane.q;
  const double* g = group.m;
  Eigen::Matrix4d M;
  M << g[0], g[1], g[2], g[3], g[1], g[4], g[5], g[6], g[2], g[5], g[7], g[8], g[3], g[6], g[8],
      g[9];
  Eigen::Matrix<double, 6, 4> L = Eigen::Matrix<double, 6, 4>::Zero();
  L.block<3, 3>(0, 0) = -skew(m);
  L.block<3, 1>(3, 3) = plane.n;
  Eigen::Vector4d rho;
  rho << m, plane.n.dot(t);
  Eigen::Matrix<double, 3, 4> B;
  B << (R.transpose() * plane.e1).transpose(), plane.e1.dot(t),
      (R.transpose() * plane.e2).transpose(), plane.e2.dot(t), 0.0, 0.0, 0.0, -1.0;

  const Eigen::Matrix<double, 6, 4> LM = L * M;
  const Eigen::Matrix<double, 3, 4> BM = B * M;
  Mat3 S = BM * B.transpose();
  S.diagonal() += Vec3(1.0 / plane.var_tilt1, 1.0 / plane.var_tilt2, 1.0 / plane.var_offset);
  const Eigen::Matrix<double, 6, 3> HA = LM * B.transpose();
  const Eigen::Matrix<double, 6, 3> K = HA * S.inverse();
  system.I.noalias() += LM * L.transpose() - K * HA.transpose();
  system.b.noalias() += LM * rho - K * (BM * rho);

  degeneracy::PlaneEvidence c;
  c.n_odom = plane.n;
  c.normal_covariance = plane.var_tilt1 * plane.e1 * plane.e1.transpose() +
                        plane.var_tilt2 * plane.e2 * plane.e2.transpose();
  c.weight = 1.0 / (1.0 / g[9] + plane.var_offset);
  c.lever_odom_m = R * Vec3(g[3], g[6], g[8]) / g[9];
  c.points = group.points;
  evidence_.push_back(c);
}

}  // namespace rali::odometry
