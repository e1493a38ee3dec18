#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/imu/rotation_study.hpp"

namespace rali::inspect {

/// What is known before the data are asked.
struct ExtrinsicsGiven {
  std::optional<geometry::Mat3> R_body_lidar;  ///< empty: not given
  geometry::Mat3 R_body_imu = geometry::Mat3::Identity();
  std::string origin = "settings";  ///< of R_body_lidar: settings, /tf_static
};

/// D09: gyro unit by the ratio of both rotations.
void report_gyro_unit(const imu::RotationStudy& study, const std::string& topic, FindingList& out);

/// D12: time offset, with its own uncertainty, or why there is none.
void report_time_offset(const imu::RotationStudy& study, const std::string& topic,
                        FindingList& out);

/// D11: the given rotation of the LiDAR against the data, its inverse, and swapped axes. What the
/// vehicle's turning does not show (the angle about the only axis it turned about) is said.
void report_extrinsics(const imu::RotationStudy& study, const ExtrinsicsGiven& given,
                       std::span<const imu::LidarTurn> lidar,
                       std::span<const sensor::ImuSample> imu, FindingList& out);

/// D07: the ground's normal, turned into the IMU, against gravity; and mirrored axes, which only
/// normal and turning together show.
/// @param up_lidar unit normal of the ground, pointing up; up_imu against gravity
void report_up(const std::optional<geometry::Vec3>& up_lidar, const geometry::Vec3& up_imu,
               const imu::RotationStudy& study, const ExtrinsicsGiven& given,
               const std::string& topic, FindingList& out);

}  // namespace rali::inspect
