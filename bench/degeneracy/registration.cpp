#include "registration.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace rali::degeneracy_bench {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kOff_m = 0.1;
constexpr double kDegenerate_m = 0.05;
constexpr double kHome_m = 0.01;
constexpr int kIterations = 25;

/// Pose covariance for the gate of the matcher.
Mat6 pose_covariance(double sigma_rad, double sigma_m) {
  Vec6 variance;
  variance << Vec3::Constant(sigma_rad * sigma_rad), Vec3::Constant(sigma_m * sigma_m);
  return variance.asDiagonal();
}

}  // namespace

TrueMap::TrueMap(const odometry::RobustSettings& settings)
    : settings_(settings),
      sampler_(settings.sampling),
      map_(settings.map),
      matcher_(settings.match) {}

void TrueMap::fill(const std::vector<std::uint32_t>& indices, const Station& station,
                   const sensor::Calibration& calibration, double mask_m,
                   odometry::BodyPoints& out) {
  const odometry::ScanMotion motion(station.poses, station.scan->t_start, calibration.T_body_lidar);
  odometry::BodyPoints all;
  motion.apply(*station.scan, indices, all);
  out.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Vec3 p = station.T_world_body * Vec3(all.x_m[i], all.y_m[i], all.z_m[i]);
    const bool masked =
        std::any_of(station.others_world_m.begin(), station.others_world_m.end(),
                    [&](const Vec3& other) { return mask_m > 0.0 && (p - other).norm() < mask_m; });
    if (masked) continue;
    out.x_m.push_back(all.x_m[i]);
    out.y_m.push_back(all.y_m[i]);
    out.z_m.push_back(all.z_m[i]);
    out.age_s.push_back(all.age_s[i]);
  }
}

void TrueMap::look(const Station& station, const sensor::Calibration& calibration, double mask_m) {
  sampler_.sample(*station.scan);
  fill(sampler_.update_indices(), station, calibration, mask_m, update_);
  fill(sampler_.insert_indices(), station, calibration, mask_m, insert_);
  T_world_body_ = station.T_world_body;
  p_body_lidar_ = calibration.T_body_lidar.p;
  matcher_.set_points(update_, p_body_lidar_);
}

void TrueMap::insert() {
  for (std::size_t i = 0; i < insert_.size(); ++i) {
    const Vec3 p(insert_.x_m[i], insert_.y_m[i], insert_.z_m[i]);
    const Vec3 ray = T_world_body_.R * (p - p_body_lidar_).normalized();
    map_.insert(T_world_body_ * p, ray.cast<float>(), 0.0);
  }
}

odometry::LidarSystem TrueMap::at_truth() {
  matcher_.match(map_, T_world_body_, pose_covariance(0.003, 0.02), odometry::Reach::kPoints);
  return matcher_.accumulate(map_, T_world_body_);
}

Mat6 TrueMap::unweighted() const {
  constexpr double kGate_m = 0.2;
  Mat6 H = Mat6::Zero();
  for (std::size_t i = 0; i < update_.size(); ++i) {
    const Vec3 arm = T_world_body_.R * Vec3(update_.x_m[i], update_.y_m[i], update_.z_m[i]);
    const int index = map_.find(arm + T_world_body_.p);
    if (index < 0) continue;
    const odometry::Plane& plane = map_.plane(index);
    if (std::abs(plane.n.dot(arm + T_world_body_.p - plane.q)) > kGate_m) continue;
    Vec6 h;
    h << arm.cross(plane.n), plane.n;
    H += h * h.transpose();
  }
  return H;
}

double TrueMap::error_from(const Vec3& offset_world_m) {
  SE3 T = T_world_body_;
  T.p += offset_world_m;
  const Mat6 gate = pose_covariance(0.01, kOff_m);
  for (int k = 0; k < kIterations; ++k) {
    matcher_.match(map_, T, gate, odometry::Reach::kPoints);
    odometry::LidarSystem system = matcher_.accumulate(map_, T);
    // Only against division by zero: as a prior its sigma would be 30 m.
    system.I.diagonal().array() += 1e-3;
    Vec6 step = -system.I.ldlt().solve(system.b);
    const double length = step.tail<3>().norm();
    if (length > 0.3) step *= 0.3 / length;
    T = geometry::boxplus(T, step);
    if (length < 0.0005 && step.head<3>().norm() < 1e-4) break;
    if ((T.p - T_world_body_.p).norm() > 3.0) break;
  }
  return (T.p - T_world_body_.p).head<2>().norm();
}

Achieved TrueMap::register_from_beside() {
  const Vec3 ahead = (T_world_body_.R.col(0) - T_world_body_.R(2, 0) * Vec3::UnitZ()).normalized();
  const Vec3 left = Vec3::UnitZ().cross(ahead);
  Achieved out;
  for (const Vec3& direction : {ahead, left}) {
    const double plus = error_from(kOff_m * direction);
    const double minus = error_from(-kOff_m * direction);
    out.worst_m = std::max({out.worst_m, plus, minus});
    if (std::max(plus, minus) < kDegenerate_m || std::min(plus, minus) > kHome_m) continue;
    // One start converged. If that is due to observability, starts at half the distance converge
    // too.
    out.wrong_minimum = out.wrong_minimum || (error_from(0.5 * kOff_m * direction) < kHome_m &&
                                              error_from(-0.5 * kOff_m * direction) < kHome_m);
  }
  out.degenerate = out.worst_m > kDegenerate_m;
  return out;
}

}  // namespace rali::degeneracy_bench
