#pragma once

#include <span>

#include "rali/drive/input/input_report.hpp"
#include "rali/geometry/types.hpp"
#include "rali/imu/rotation_study.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Whether LiDAR and IMU turn alike under an assumed rotation between them, and which rotation
/// makes them turn alike. A vehicle on a road turns about one axis: both sensors show where that
/// axis lies; about it the result keeps the assumed rotation.
[[nodiscard]] MountingByTurning judge_mounting(const geometry::Mat3& R_imu_lidar_assumed,
                                               std::span<const imu::LidarTurn> lidar,
                                               std::span<const sensor::ImuSample> imu,
                                               const imu::RotationStudy& study);

}  // namespace rali::drive
