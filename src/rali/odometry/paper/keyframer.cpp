#include "rali/odometry/paper/keyframer.hpp"

namespace rali::odometry::paper {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3f;

namespace {

// The registration's information is of the pose in odom (rotation in the body, position in odom);
// relative to the previous keyframe, only the position is rotated.
Mat6 in_previous_body(const Mat6& information_odom, const geometry::Mat3& R_odom_previous) {
  Mat6 G = Mat6::Identity();
  G.block<3, 3>(3, 3) = R_odom_previous;
  const Mat6 I = G.transpose() * information_odom * G;
  return 0.5 * (I + I.transpose());
}

void fill_cloud(const sensor::LidarScan& scan, const BodyPoints& cloud_lidar,
                const SE3& T_body_lidar, KeyframeCloud& out) {
  const std::size_t n = cloud_lidar.size();
  const Eigen::Matrix3f R = T_body_lidar.R.cast<float>();
  const Vec3f t = T_body_lidar.p.cast<float>();
  for (auto* v : {&out.x_m, &out.y_m, &out.z_m}) v->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f p = R * Vec3f(cloud_lidar.x_m[i], cloud_lidar.y_m[i], cloud_lidar.z_m[i]) + t;
    out.x_m[i] = p.x();
    out.y_m[i] = p.y();
    out.z_m[i] = p.z();
  }
  out.intensity = scan.intensity;
  out.ring = scan.ring;
}

}  // namespace

OverlapKeyframer::OverlapKeyframer(double overlap_min, double radius_m, const SE3& T_body_lidar)
    : overlap_min_(overlap_min), radius_m_(radius_m), T_body_lidar_(T_body_lidar) {}

double OverlapKeyframer::overlap(const BodyPoints& cloud_lidar,
                                 std::span<const std::uint32_t> thinned,
                                 const SE3& T_odom_body) const {
  if (thinned.empty()) return 1.0;
  const SE3 T_last_now =
      (T_odom_body_last_ * T_body_lidar_).inverse() * (T_odom_body * T_body_lidar_);
  const Eigen::Matrix3f R = T_last_now.R.cast<float>();
  const Vec3f p = T_last_now.p.cast<float>();
  std::size_t inside = 0;
  for (const std::uint32_t i : thinned) {
    const Vec3f q = R * Vec3f(cloud_lidar.x_m[i], cloud_lidar.y_m[i], cloud_lidar.z_m[i]) + p;
    if (tree_.any_within(q, static_cast<float>(radius_m_))) ++inside;
  }
  return static_cast<double>(inside) / static_cast<double>(thinned.size());
}

std::shared_ptr<const Keyframe> OverlapKeyframer::make(const sensor::LidarScan& scan,
                                                       const BodyPoints& cloud_lidar,
                                                       std::span<const std::uint32_t> thinned,
                                                       const ScanResult& result) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->t = result.t;
  keyframe->T_odom_body = result.T_odom_body;
  keyframe->covariance = result.covariance;
  keyframe->T_body_lidar = T_body_lidar_;
  if (has_last_) {
    keyframe->T_previous_this = T_odom_body_last_.inverse() * result.T_odom_body;
    keyframe->information_relative =
        in_previous_body(result.lidar_information, T_odom_body_last_.R);
  }
  fill_cloud(scan, cloud_lidar, T_body_lidar_, keyframe->cloud);

  for (auto* v : {&x_m_, &y_m_, &z_m_}) v->clear();
  for (const std::uint32_t i : thinned) {
    x_m_.push_back(cloud_lidar.x_m[i]);
    y_m_.push_back(cloud_lidar.y_m[i]);
    z_m_.push_back(cloud_lidar.z_m[i]);
  }
  tree_.build(x_m_, y_m_, z_m_);
  T_odom_body_last_ = result.T_odom_body;
  t_last_ = result.t;
  has_last_ = true;
  return keyframe;
}

}  // namespace rali::odometry::paper
