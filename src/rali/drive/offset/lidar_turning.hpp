#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/imu/rotation_study.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::drive {

/// Where the LiDAR was in the frame of its odometry. Pieces are apart where it was lost.
struct TrackPoint {
  Time t;
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  std::uint32_t piece = 0;
};

/// How the LiDAR turned from sweep to sweep, by a LiDAR odometry of its own: without inertial data
/// and with the LiDAR as the body, so that it owes nothing to gyro or extrinsics and can be
/// compared with both.
class LidarTurning {
 public:
  /// @param settings how many points of each scan it takes, and the like.
  explicit LidarTurning(const odometry::OdometrySettings& settings = {});

  /// Sweeps in the order of time; one without points is passed over.
  void see(const sensor::LidarScan& scan, Executor& executor);

  [[nodiscard]] const std::vector<imu::LidarTurn>& turns() const { return turns_; }

  /// Its positions, by time.
  [[nodiscard]] const std::vector<TrackPoint>& track() const { return track_; }

  /// Sweeps with points.
  [[nodiscard]] std::uint64_t sweeps() const { return sweeps_; }

  /// Sweeps in which LiDAR alone lost its way.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  std::unique_ptr<odometry::Odometry> odometry_;
  std::optional<std::pair<Time, geometry::Mat3>> last_;
  std::vector<imu::LidarTurn> turns_;
  std::vector<TrackPoint> track_;
  std::uint32_t piece_ = 0;
  std::uint64_t sweeps_ = 0, lost_ = 0;
};

}  // namespace rali::drive
