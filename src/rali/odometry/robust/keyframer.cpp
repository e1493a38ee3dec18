#include "rali/odometry/robust/keyframer.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace rali::odometry {

using geometry::Mat6;
using geometry::SE3;

namespace {

// Registration against a map built from the last poses is not independent: the sigma of a relative
// pose has a lower bound (algorithms 6.2).
constexpr double kSigmaFloor_m = 0.005;
constexpr double kSigmaPerMeter = 0.001;
constexpr double kSigmaFloor_rad = 0.02 * std::numbers::pi / 180.0;
constexpr double kSigmaPerRootMeter_rad = 0.01 * std::numbers::pi / 180.0;

/// Information of the relative pose in the previous body, capped; degenerate directions stay at
/// zero.
Mat6 relative_information(const Mat6& I_odom, const SE3& previous, double distance_m) {
  Mat6 G = Mat6::Identity();
  G.block<3, 3>(3, 3) = previous.R;
  const Mat6 I = G.transpose() * I_odom * G;
  const double sigma_m = kSigmaFloor_m + kSigmaPerMeter * distance_m;
  const double sigma_rad = kSigmaFloor_rad + kSigmaPerRootMeter_rad * std::sqrt(distance_m);
  Mat6 C = Mat6::Zero();
  C.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  C.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
  const Mat6 capped = (Mat6::Identity() + I * C).partialPivLu().solve(I);
  return 0.5 * (capped + capped.transpose());
}

}  // namespace

bool Keyframer::wants(const SE3& T_odom_body) const {
  if (!has_last_) return true;
  const double angle_deg =
      geometry::so3_log(last_.R.transpose() * T_odom_body.R).norm() * 180.0 / std::numbers::pi;
  return (T_odom_body.p - last_.p).norm() > settings_.distance_m || angle_deg > settings_.angle_deg;
}

std::shared_ptr<const Keyframe> Keyframer::make(const sensor::LidarScan& scan,
                                                const BodyPoints& points, const ScanResult& result,
                                                const SE3& T_body_lidar) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->t = result.t;
  keyframe->T_odom_body = result.T_odom_body;
  keyframe->covariance = result.covariance;
  keyframe->T_body_lidar = T_body_lidar;
  if (has_last_) {
    keyframe->T_previous_this = last_.inverse() * result.T_odom_body;
    keyframe->information_relative =
        relative_information(result.lidar_information, last_, keyframe->T_previous_this.p.norm());
  }
  std::vector<std::uint32_t> indices;
  if (settings_.voxel_m > 0.0) {
    const cloud::PointSpan span{points.x_m.data(), points.y_m.data(), points.z_m.data(),
                                points.size()};
    sampler_.sample(span, {}, settings_.voxel_m, indices);
  } else {
    for (std::uint32_t i = 0; i < points.size(); ++i) indices.push_back(i);
  }
  KeyframeCloud& cloud = keyframe->cloud;
  for (std::vector<float>* v : {&cloud.x_m, &cloud.y_m, &cloud.z_m, &cloud.intensity}) {
    v->reserve(indices.size());
  }
  cloud.ring.reserve(indices.size());
  for (const std::uint32_t i : indices) {
    cloud.x_m.push_back(points.x_m[i]);
    cloud.y_m.push_back(points.y_m[i]);
    cloud.z_m.push_back(points.z_m[i]);
    cloud.intensity.push_back(scan.intensity[i]);
    cloud.ring.push_back(scan.ring[i]);
  }
  last_ = result.T_odom_body;
  has_last_ = true;
  return keyframe;
}

}  // namespace rali::odometry
