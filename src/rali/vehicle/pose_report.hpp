#pragma once

#include "rali/degeneracy/information.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::vehicle {

/// The odometry's result as the pose that the vehicle reports.
[[nodiscard]] PoseEstimate pose_of(VehicleId self, const odometry::ScanResult& result);

/// Sigma of roll and pitch of a frame, by the gravity estimated in it.
/// @param covariance_m2ps4 of gravity
[[nodiscard]] double level_sigma_rad(const geometry::Vec3& g_mps2,
                                     const geometry::Mat3& covariance_m2ps4);

/// The observability of all directions in one scan. If the odometry does not evaluate directions
/// itself (preset `paper`), they are computed from its information. @param axes of the last scan,
/// updated.
[[nodiscard]] degeneracy::Report degeneracy_of(const odometry::ScanResult& result,
                                               const odometry::OdometrySettings& settings,
                                               const geometry::Vec3& g_odom_mps2,
                                               degeneracy::Axes& axes);

}  // namespace rali::vehicle
