#pragma once

#include <memory>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/deskew.hpp"
#include "rali/odometry/keyframe.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/robust/settings.hpp"

namespace rali::odometry {

/// Decides which scans are kept for the map, and makes keyframes of them.
class Keyframer {
 public:
  explicit Keyframer(const KeyframeSettings& settings) : settings_(settings) {}

  /// True if the vehicle has moved far enough since the last keyframe (or there is none).
  [[nodiscard]] bool wants(const geometry::SE3& T_odom_body) const;

  /// @param points all points of `scan` in the body at its end, same order.
  [[nodiscard]] std::shared_ptr<const Keyframe> make(const sensor::LidarScan& scan,
                                                     const BodyPoints& points,
                                                     const ScanResult& result,
                                                     const geometry::SE3& T_body_lidar);

 private:
  KeyframeSettings settings_;
  cloud::VoxelSampler sampler_;
  bool has_last_ = false;
  geometry::SE3 last_;
};

}  // namespace rali::odometry
