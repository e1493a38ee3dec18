#pragma once

#include <cstdint>
#include <span>

#include "rali/geometry/types.hpp"
#include "rali/imu/rotation_study.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::imu {

enum class MountingVerdict : std::uint8_t { kUndecided, kAgrees, kContradicts };

/// What the turning of LiDAR and IMU says of the rotation between them.
struct MountingByTurning {
  MountingVerdict verdict = MountingVerdict::kUndecided;  ///< on the one that was given or assumed
  geometry::Mat3 R_imu_lidar = geometry::Mat3::Identity();  ///< makes both turn alike
  double assumed_misfit_rad = 0.0;  ///< of the one that was given or assumed
  double misfit_rad = 0.0;          ///< of R_imu_lidar
};

/// Whether LiDAR and IMU turn alike under an assumed rotation between them, and which rotation
/// makes them turn alike. A vehicle on a road turns about one axis: both sensors show where that
/// axis lies; about it the result keeps the assumed rotation.
[[nodiscard]] MountingByTurning judge_mounting(const geometry::Mat3& R_imu_lidar_assumed,
                                               std::span<const LidarTurn> lidar,
                                               std::span<const sensor::ImuSample> samples,
                                               const RotationStudy& study);

}  // namespace rali::imu
