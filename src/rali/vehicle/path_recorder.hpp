#pragma once

#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/imu/preintegration.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// A node of the vehicle's path, and its time.
struct PathNode {
  Time t;
  fleet::Increment step;
};

/// Thins the scans of a vehicle to the nodes of a pose graph. Each is connected to the one before
/// by the information of the LiDAR and the inertial data between. Keyframes are nodes; between them
/// one a second while driving, fewer at standstill.
class PathRecorder {
 public:
  explicit PathRecorder(const VehicleSettings& settings) : settings_(settings) {}

  void add(const sensor::ImuSample& sample);

  /// Call after each scan. @return the node, if it is one
  /// @param level_sigma_rad of the direction of gravity; 0: not known
  [[nodiscard]] std::optional<PathNode> add(const odometry::ScanResult& result,
                                            const std::optional<KeyframeId>& keyframe,
                                            bool degenerate, const geometry::Vec3& g_odom_mps2,
                                            double level_sigma_rad);

  /// The map was lost: the next node is not connected to any before it.
  void cut() { last_.reset(); }

 private:
  [[nodiscard]] bool wants(const odometry::ScanResult& result, bool keyframe) const;
  [[nodiscard]] std::optional<graph::InertialFactor> preintegrate(
      Time from, Time to, const imu::InertialBias& bias, const imu::NoiseDensity& noise) const;

  VehicleSettings settings_;
  std::vector<sensor::ImuSample> imu_;  ///< since the last node
  std::optional<Time> last_;            ///< the last node, if the next one is connected to it
  bool last_at_rest_ = false;
  std::uint32_t nodes_ = 0;
};

}  // namespace rali::vehicle
