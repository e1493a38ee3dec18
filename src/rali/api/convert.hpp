#pragma once

#include <array>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/types.hpp"
#include "rali/vehicle.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::api {

/// Names of the fleet's vehicles by their number.
using VehicleNames = std::vector<std::string>;

[[nodiscard]] Pose3 public_pose(const geometry::SE3& T);
[[nodiscard]] geometry::SE3 inner_pose(const Pose3& T);

/// @param covariance of geometry::boxplus
[[nodiscard]] Covariance6 public_covariance(const geometry::Mat6& covariance,
                                            const geometry::SE3& T_outer_body);

/// @param vehicle name used where the finding has none
[[nodiscard]] RunFinding public_finding(const Finding& finding, const std::string& vehicle = {});

[[nodiscard]] PoseEstimate public_estimate(const vehicle::PoseEstimate& pose,
                                           const std::string& name);
[[nodiscard]] Keyframe public_keyframe(const vehicle::KeyframeAdded& added,
                                       const std::string& name);
[[nodiscard]] RangeResult public_range(const ranging::RangeUse& use, const VehicleNames& names);
[[nodiscard]] RangeMeasurement public_range(const sensor::RangeSample& sample,
                                            const VehicleNames& names);

/// The scan without its unusable points, which are counted. Takes over the arrays of `scan`.
/// Errors (kInput): arrays of different length.
[[nodiscard]] Result<sensor::LidarScan> inner_scan(Scan scan, const std::array<double, 2>& range_m);

[[nodiscard]] Scan public_scan(const sensor::LidarScan& scan);

}  // namespace rali::api
