#include "rali/odometry/deskew.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"

namespace rali::odometry {
namespace {

constexpr double kTableStep_s = 0.0025;
constexpr int kTableMax = 4096;  // 10 s: longer durations are invalid, points are clamped

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

ScanMotion::ScanMotion(std::span<const TimedPose> poses, Time t_start,
                       const geometry::SE3& T_body_lidar)
    : t_start_(t_start) {
  RALI_ASSERT(!poses.empty());
  const geometry::SE3 T_end_odom = poses.back().T_odom_body.inverse();
  const double span_s = std::max(0.0, (poses.back().t - t_start).s());
  const int steps = std::min(kTableMax, static_cast<int>(std::ceil(span_s / kTableStep_s)));
  const double step_s = steps > 0 ? span_s / steps : 0.0;
  step_inverse_ = steps > 0 ? static_cast<float>(1.0 / step_s) : 0.0F;
  T_end_lidar_.resize(static_cast<std::size_t>(steps) + 2);
  for (int k = 0; k <= steps; ++k) {
    const geometry::SE3 T_odom_body = pose_at(poses, t_start + Duration::from_s(k * step_s));
    const geometry::SE3 T = T_end_odom * T_odom_body * T_body_lidar;
    T_end_lidar_[static_cast<std::size_t>(k)] << T.R.cast<float>(), T.p.cast<float>();
  }
  T_end_lidar_.back() = T_end_lidar_[static_cast<std::size_t>(steps)];
}

ScanMotion::ScanMotion(const geometry::SE3& T_body_lidar) : T_end_lidar_(2) {
  T_end_lidar_[0] << T_body_lidar.R.cast<float>(), T_body_lidar.p.cast<float>();
  T_end_lidar_[1] = T_end_lidar_[0];
}

namespace {

/// Some points of a scan and the position of each one's time in the table, in flat arrays that the
/// compiler can vectorise.
struct Block {
  static constexpr std::size_t kSize = 64;
  float x[kSize], y[kSize], z[kSize], dt[kSize];
  float fraction[kSize];
  int cell[kSize];
};

void load(const sensor::LidarScan& scan, std::span<const std::uint32_t> indices, std::size_t first,
          std::size_t n, Block& b) {
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = indices.empty() ? first + k : indices[first + k];
    b.x[k] = scan.x_m[i];
    b.y[k] = scan.y_m[i];
    b.z[k] = scan.z_m[i];
    b.dt[k] = scan.dt_s[i];
  }
}

/// Transforms points begin to end of the block, all between the transforms a and b (column-major
/// 3x4).
void transform(const Block& p, std::size_t begin, std::size_t end, const float* a, const float* b,
               float* x, float* y, float* z) {
  float d[12];
  for (int j = 0; j < 12; ++j) d[j] = b[j] - a[j];
  for (std::size_t k = begin; k < end; ++k) {
    const float f = p.fraction[k];
    x[k] = (a[0] + f * d[0]) * p.x[k] + (a[3] + f * d[3]) * p.y[k] + (a[6] + f * d[6]) * p.z[k] +
           (a[9] + f * d[9]);
    y[k] = (a[1] + f * d[1]) * p.x[k] + (a[4] + f * d[4]) * p.y[k] + (a[7] + f * d[7]) * p.z[k] +
           (a[10] + f * d[10]);
    z[k] = (a[2] + f * d[2]) * p.x[k] + (a[5] + f * d[5]) * p.y[k] + (a[8] + f * d[8]) * p.z[k] +
           (a[11] + f * d[11]);
  }
}

}  // namespace

void ScanMotion::apply(const sensor::LidarScan& scan, std::span<const std::uint32_t> indices,
                       BodyPoints& out) const {
  const std::size_t n = indices.empty() ? scan.size() : indices.size();
  out.resize(n);
  const int last = static_cast<int>(T_end_lidar_.size()) - 2;
  const float span_s = static_cast<float>((scan.t_end - scan.t_start).s());
  const float shift_s = static_cast<float>((scan.t_start - t_start_).s());
  const bool moving = step_inverse_ > 0.0F && scan.has_point_times && !scan.deskewed;
  Block b{};
  for (std::size_t first = 0; first < n; first += Block::kSize) {
    const std::size_t size = std::min(Block::kSize, n - first);
    load(scan, indices, first, size, b);
    for (std::size_t k = 0; k < size; ++k) {
      const float u = moving ? (b.dt[k] + shift_s) * step_inverse_ : static_cast<float>(last);
      b.cell[k] = std::clamp(static_cast<int>(u), 0, last);
      b.fraction[k] = std::clamp(u - static_cast<float>(b.cell[k]), 0.0F, 1.0F);
      out.age_s[first + k] = moving ? span_s - b.dt[k] : 0.0F;
    }
    // Points are nearly in order of time: long runs use the same two transforms.
    for (std::size_t begin = 0, end = 0; begin < size; begin = end) {
      const int cell = b.cell[begin];
      while (end < size && b.cell[end] == cell) ++end;
      const auto at = static_cast<std::size_t>(cell);
      transform(b, begin, end, T_end_lidar_[at].data(), T_end_lidar_[at + 1].data(),
                out.x_m.data() + first, out.y_m.data() + first, out.z_m.data() + first);
    }
  }
}

}  // namespace rali::odometry
