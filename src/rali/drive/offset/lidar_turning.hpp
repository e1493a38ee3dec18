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
#include "rali/ranging/peer_fit.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::drive {

/// Rotation of the LiDAR from scan to scan, by a separate LiDAR odometry: without inertial data and
/// with the LiDAR as the body. It is thus independent of gyro and extrinsics and can be compared
/// with both.
class LidarTurning {
 public:
  /// @param settings number of points taken from each scan, and the like.
  explicit LidarTurning(const odometry::OdometrySettings& settings = {});

  /// Scans in time order; a scan without points is skipped.
  void see(const sensor::LidarScan& scan, Executor& executor);

  [[nodiscard]] const std::vector<imu::LidarTurn>& turns() const { return turns_; }

  /// Positions of the LiDAR, by time.
  [[nodiscard]] const std::vector<ranging::TrackPoint>& track() const { return track_; }

  /// Scans with points.
  [[nodiscard]] std::uint64_t scans() const { return scans_; }

  /// Of the scans; 0 to 1.
  [[nodiscard]] double degenerate_fraction() const {
    return scans_ > 0 ? static_cast<double>(degenerate_) / static_cast<double>(scans_) : 0.0;
  }

  /// Scans in which the LiDAR odometry lost tracking.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  std::unique_ptr<odometry::Odometry> odometry_;
  std::optional<std::pair<Time, geometry::Mat3>> last_;
  std::vector<imu::LidarTurn> turns_;
  std::vector<ranging::TrackPoint> track_;
  std::uint32_t piece_ = 0;
  std::uint64_t scans_ = 0, lost_ = 0, degenerate_ = 0;
};

}  // namespace rali::drive
