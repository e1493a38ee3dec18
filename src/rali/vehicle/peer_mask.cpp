#include "rali/vehicle/peer_mask.hpp"

#include <algorithm>
#include <vector>

namespace rali::vehicle {

using geometry::Vec3;
using geometry::Vec3f;
using sensor::LidarScan;

namespace {

/// A standing cylinder in the frame of the LiDAR.
struct Cylinder {
  Vec3f p;
  Vec3f up;
};

bool holds(const Cylinder& c, const Vec3f& point, const PeerMaskSettings& s) {
  const Vec3f d = point - c.p;
  const float height = d.dot(c.up);
  if (height > static_cast<float>(s.above_m) || height < -static_cast<float>(s.below_m)) {
    return false;
  }
  const auto radius = static_cast<float>(s.radius_m);
  return (d - height * c.up).squaredNorm() < radius * radius;
}

}  // namespace

std::shared_ptr<const LidarScan> without_peers(const LidarScan& scan,
                                               const geometry::SE3& T_odom_lidar,
                                               std::span<const Vec3> antennas_odom_m,
                                               const Vec3& up_odom,
                                               const PeerMaskSettings& settings) {
  const geometry::SE3 T_lidar_odom = T_odom_lidar.inverse();
  std::vector<Cylinder> cylinders;
  for (const Vec3& p : antennas_odom_m) {
    cylinders.push_back(
        {(T_lidar_odom * p).cast<float>(), (T_lidar_odom.R * up_odom).cast<float>()});
  }
  const auto masked = [&](std::size_t i) {
    const Vec3f point(scan.x_m[i], scan.y_m[i], scan.z_m[i]);
    return std::any_of(cylinders.begin(), cylinders.end(),
                       [&](const Cylinder& c) { return holds(c, point, settings); });
  };
  std::size_t first = 0;
  while (first < scan.size() && !masked(first)) ++first;
  if (first == scan.size()) return nullptr;
  auto out = std::make_shared<LidarScan>(scan);  // with all that is not a point
  for (std::vector<float>* v : {&out->x_m, &out->y_m, &out->z_m, &out->intensity, &out->dt_s}) {
    v->clear();
  }
  out->ring.clear();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (i >= first && masked(i)) continue;
    out->push_back(scan.x_m[i], scan.y_m[i], scan.z_m[i], scan.intensity[i], scan.dt_s[i],
                   scan.ring[i]);
  }
  return out;
}

}  // namespace rali::vehicle
