#include "rali/odometry/deskew.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"

namespace rali::odometry {
namespace {

constexpr double kTableStep_s = 0.0025;
constexpr int kTableMax = 4096;  // 10 s: longer sweeps are no sweeps, points are clamped

geometry::SE3 pose_at(std::span<const TimedPose> poses, Time t) {
  if (poses.size() == 1) return poses.front().T_odom_body;
  std::size_t k = 1;
  while (k + 1 < poses.size() && poses[k].t < t) ++k;
  const TimedPose& a = poses[k - 1];
  const TimedPose& b = poses[k];
  const double span_s = (b.t - a.t).s();
  if (span_s <= 0.0) return b.T_odom_body;
  return geometry::interpolate(a.T_odom_body, b.T_odom_body, (t - a.t).s() / span_s);
}

}  // namespace

void BodyPoints::clear() { resize(0); }

void BodyPoints::resize(std::size_t n) {
  for (std::vector<float>* v : {&x_m, &y_m, &z_m, &age_s}) v->resize(n);
}

SweepMotion::SweepMotion(std::span<const TimedPose> poses, Time t_begin,
                         const geometry::SE3& T_body_lidar)
    : t_begin_(t_begin) {
  RALI_ASSERT(!poses.empty());
  const geometry::SE3 T_end_odom = poses.back().T_odom_body.inverse();
  const double span_s = std::max(0.0, (poses.back().t - t_begin).s());
  const int steps = std::min(kTableMax, static_cast<int>(std::ceil(span_s / kTableStep_s)));
  const double step_s = steps > 0 ? span_s / steps : 0.0;
  step_inverse_ = steps > 0 ? static_cast<float>(1.0 / step_s) : 0.0F;
  T_end_lidar_.resize(static_cast<std::size_t>(steps) + 2);
  for (int k = 0; k <= steps; ++k) {
    const geometry::SE3 T_odom_body = pose_at(poses, t_begin + Duration::from_s(k * step_s));
    const geometry::SE3 T = T_end_odom * T_odom_body * T_body_lidar;
    T_end_lidar_[static_cast<std::size_t>(k)] << T.R.cast<float>(), T.p.cast<float>();
  }
  T_end_lidar_.back() = T_end_lidar_[static_cast<std::size_t>(steps)];
}

SweepMotion::SweepMotion(const geometry::SE3& T_body_lidar) : T_end_lidar_(2) {
  T_end_lidar_[0] << T_body_lidar.R.cast<float>(), T_body_lidar.p.cast<float>();
  T_end_lidar_[1] = T_end_lidar_[0];
}

void SweepMotion::apply(const sensor::LidarScan& scan, std::span<const std::uint32_t> indices,
                        BodyPoints& out) const {
  const std::size_t n = indices.empty() ? scan.size() : indices.size();
  out.resize(n);
  const int last = static_cast<int>(T_end_lidar_.size()) - 2;
  const float span_s = static_cast<float>((scan.t_end - scan.t_begin).s());
  const float shift_s = static_cast<float>((scan.t_begin - t_begin_).s());
  const bool moving = step_inverse_ > 0.0F && scan.has_point_times && !scan.deskewed;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = indices.empty() ? k : indices[k];
    const float dt = scan.dt_s[i];
    const float u = moving ? (dt + shift_s) * step_inverse_ : static_cast<float>(last);
    const int cell = std::clamp(static_cast<int>(u), 0, last);
    const float f = std::clamp(u - static_cast<float>(cell), 0.0F, 1.0F);
    const float* a = T_end_lidar_[static_cast<std::size_t>(cell)].data();
    const float* b = T_end_lidar_[static_cast<std::size_t>(cell) + 1].data();
    float m[12];
    for (int j = 0; j < 12; ++j) m[j] = a[j] + f * (b[j] - a[j]);  // column-major 3x4
    const float x = scan.x_m[i];
    const float y = scan.y_m[i];
    const float z = scan.z_m[i];
    out.x_m[k] = m[0] * x + m[3] * y + m[6] * z + m[9];
    out.y_m[k] = m[1] * x + m[4] * y + m[7] * z + m[10];
    out.z_m[k] = m[2] * x + m[5] * y + m[8] * z + m[11];
    out.age_s[k] = moving ? span_s - dt : 0.0F;
  }
}

}  // namespace rali::odometry
