#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/imu/rotation_study.hpp"

namespace rali::inspect {

/// Extrinsics given before the data are examined.
struct ExtrinsicsGiven {
  std::optional<geometry::Mat3> R_body_lidar;  ///< empty: not given
  geometry::Mat3 R_body_imu = geometry::Mat3::Identity();
  std::string origin = "settings";  ///< of R_body_lidar: settings, /tf_static
};

/// D09: gyro unit from the ratio of both rotations.
/// @param degenerate_fraction of the scans. In a degenerate bend the LiDAR measures its turn only
/// as well as its way, so the ratio shows no scale error there, only another unit.
void report_gyro_unit(const imu::RotationStudy& study, double degenerate_fraction,
                      const std::string& topic, FindingList& out);

/// D12: time offset, with its uncertainty, or why there is none.
void report_time_offset(const imu::RotationStudy& study, const std::string& topic,
                        FindingList& out);

/// D11: the given rotation of the LiDAR against the data, its inverse, and swapped axes. An
/// unobservable angle (about the only axis of the vehicle's rotation) is reported.
void report_extrinsics(const imu::RotationStudy& study, const ExtrinsicsGiven& given,
                       std::span<const imu::LidarTurn> lidar,
                       std::span<const sensor::ImuSample> imu, FindingList& out);

/// D07: the ground's normal, rotated into the IMU frame, against gravity. Also mirrored axes, which
/// only normal and rotation together reveal.
/// @param up_lidar unit normal of the ground, pointing up; up_imu against gravity
void report_up(const std::optional<geometry::Vec3>& up_lidar, const geometry::Vec3& up_imu,
               const imu::RotationStudy& study, const ExtrinsicsGiven& given,
               const std::string& topic, FindingList& out);

}  // namespace rali::inspect
