#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/lidar_scan.hpp"

namespace rali::drive {

/// Directions of the large planes around the LiDAR, in the LiDAR frame.
struct PlaneDirection {
  geometry::Vec3 n_lidar;  ///< unit; points from the plane to the sensor
  double fraction = 0.0;   ///< of all points that lie on planes
};

/// The large planes of the first scans, most points first; at most eight.
[[nodiscard]] std::vector<PlaneDirection> plane_directions(
    std::span<const sensor::LidarScan> scans);

/// Tilt between the gravity "up" and the nearest plane that could be the ground, for a given
/// rotation of the LiDAR in the body [rad]; empty without planes.
[[nodiscard]] std::optional<double> ground_tilt_rad(std::span<const PlaneDirection> planes,
                                                    const geometry::Mat3& R_body_lidar,
                                                    const geometry::Vec3& up_body);

/// Planes that may be the ground, if T_body_lidar is wrong: large ones, and those that would be
/// walls only if they are most of what is seen. None where walls, a pipe or a vault explain that no
/// level ground is seen.
[[nodiscard]] std::vector<PlaneDirection> ground_candidates(std::span<const PlaneDirection> planes,
                                                            const geometry::Mat3& R_body_lidar,
                                                            const geometry::Vec3& up_body);

/// Whether a large plane is level below the LiDAR, to 15 deg.
[[nodiscard]] bool ground_fits(std::span<const PlaneDirection> planes,
                               const geometry::Mat3& R_body_lidar, const geometry::Vec3& up_body);

/// Compares T_body_lidar with gravity and the ground, at standstill (algorithm: the ground is level
/// to 15 deg where vehicles start; U12). A mismatch is an error (kInput) that names what would fit:
/// the inverse, or another order of axes; with ExtrinsicsCheck::kWarn a finding D11. Up to
/// 40 deg may be a slope unless the inverse fits: a finding, too. Without ground_candidates()
/// gravity does not constrain the axes: no complaint.
/// @param up_body unit vector against gravity in body, from the accelerometer at standstill
[[nodiscard]] Result<FindingList> check_extrinsics(std::span<const PlaneDirection> planes,
                                                   const geometry::Mat3& R_body_lidar,
                                                   const geometry::Vec3& up_body,
                                                   const InputOptions& options);

/// "0.08 m forward, 0.25 m up of the IMU, turned 1.5 deg left".
/// @param origin name of the sensor at the body's origin
[[nodiscard]] std::string extrinsics_in_words(const geometry::SE3& T_body_sensor,
                                              const std::string& origin = "IMU");

/// The manufacturer's T_body_lidar for LiDARs with a built-in IMU (body = that IMU); empty if
/// unknown or if the IMU topic is not the LiDAR's own.
[[nodiscard]] std::optional<geometry::SE3> maker_extrinsics(const std::string& model,
                                                            const std::string& imu_topic);

}  // namespace rali::drive
