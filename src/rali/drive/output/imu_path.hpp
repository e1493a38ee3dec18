#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::drive {

/// Poses of the body in map at the stamps of the inertial samples, between the final poses.
///
/// Between two scans the rotation integrates the gyro and the position the accelerometer. The
/// remaining error at the second scan (bias of the gyro, velocity at the first scan) is spread over
/// the interval in proportion to time. The path thus passes through both final poses exactly.
/// Samples before the first and after the last scan, next to a diverged pose, and between scans
/// more than 1 s apart get no pose; where samples are missing for 0.1 s the path is interpolated.
/// @param poses by time, in the filter's frame  @param samples by time
/// @param put called for each pose, by time; its error ends the work
[[nodiscard]] Status imu_rate_poses(const std::vector<PoseRecord>& poses,
                                    const geometry::SE3& T_map_local,
                                    std::span<const sensor::ImuSample> samples,
                                    const geometry::SE3& T_body_imu,
                                    const std::function<Status(const io::StampedPose&)>& put);

/// Writes trajectory/<v>.imu.tum. Errors: kMachine.
[[nodiscard]] Status write_imu_path(const std::string& path, const std::vector<PoseRecord>& poses,
                                    const MapFrame& frame, const std::string& vehicle,
                                    std::span<const sensor::ImuSample> samples,
                                    const geometry::SE3& T_body_imu);

}  // namespace rali::drive
