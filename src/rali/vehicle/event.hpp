#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/ids.hpp"
#include "rali/degeneracy/report.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/messages/peer_status.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/odometry/keyframe.hpp"
#include "rali/ranging/range_use.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::vehicle {

/// The recording has ended: process what is still waiting for inertial data.
struct EndOfData {};

using fleet::PeerPose;
using fleet::PeerStatus;
using fleet::SeenPeer;

/// Input events of a vehicle. Order of arrival is the order of the calls.
using Event = std::variant<sensor::ImuSample, std::shared_ptr<const sensor::LidarScan>,
                           sensor::RangeSample, sensor::RadioSample, PeerStatus, EndOfData>;

/// Source of the pose of one scan: a full match of the LiDAR, a weak one, the predicted motion
/// alone, or none any more. Its uncertainty, above all along a degenerate direction, is in the
/// covariance.
enum class PoseQuality { kGood, kWeak, kPredicted, kDiverged };

/// The pose at the last point of one scan, as estimated when the scan was processed.
struct PoseEstimate {
  VehicleId vehicle;
  Time t;
  geometry::SE3 T_local_body;  ///< in the filter's frame, where LiDAR and ranges may shift it
  geometry::SE3 T_odom_body;   ///< in the frame that never jumps
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of T_local_body, geometry::boxplus
  PoseQuality quality = PoseQuality::kGood;
  degeneracy::Report degeneracy;
  int matches = 0;  ///< points with a plane
  double residual_rms_m = 0.0;
  bool at_rest = false;          ///< standstill: the pose is kept constant
  bool seeks_gravity = false;    ///< has inertial data, but gravity is not initialised by them yet
  double level_sigma_rad = 0.0;  ///< of roll and pitch of the frame `local`, by gravity
  double correction_m = 0.0;     ///< shift by ranges since the last scan
  std::optional<VehicleId> range_from;  ///< whose range caused it
};

/// An earlier keyframe as corrected by the local pose graph with later ranges. Replaces earlier
/// reports of that keyframe.
struct KeyframeCorrected {
  KeyframeId id;
  Time t;
  geometry::SE3 T_local_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
};

/// A new keyframe: an immutable fact.
struct KeyframeAdded {
  KeyframeId id;
  std::shared_ptr<const odometry::Keyframe> keyframe;
};

/// Estimate of gravity in odom, for the frame in which results are written.
struct GravityEstimate {
  VehicleId vehicle;
  Time t;
  geometry::Vec3 g_odom_mps2 = geometry::Vec3::Zero();
  geometry::Mat3 covariance = geometry::Mat3::Zero();
};

/// A fact that the other vehicles of the fleet need permanently.
struct FactMade {
  std::shared_ptr<const fleet::Fact> fact;
};

using Output = std::variant<PoseEstimate, KeyframeAdded, KeyframeCorrected, GravityEstimate,
                            ranging::RangeUse, FactMade, PeerStatus, Finding>;
using OutputList = std::vector<Output>;

}  // namespace rali::vehicle
