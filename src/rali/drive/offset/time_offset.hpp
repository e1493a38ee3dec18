#pragma once

#include <functional>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/imu/rotation_study.hpp"

namespace rali::drive {

/// Decides on the time offset between LiDAR and IMU from the rotation study. The estimate is used
/// if it is certain (sigma at most kOffsetSigmaMax_s, not at the border of the search) and
/// significant (beyond kOffsetMin_s and four sigma); else the offset is 0 and `origin` gives the
/// reason.
/// @param looked_at_s length of the data behind the study, for the text [s]
[[nodiscard]] LidarTimeOffset judge_time_offset(const imu::RotationStudy& study,
                                                double looked_at_s);

inline constexpr double kOffsetMin_s = 0.010;
inline constexpr double kOffsetSigmaMax_s = 0.010;

/// What the turning of LiDAR and IMU says of their clocks and of the rotation between them.
struct Turning {
  LidarTimeOffset offset;
  imu::MountingByTurning mounting;
};

/// Plays the start of a vehicle's input and compares the rotation of a LiDAR odometry with the
/// gyro's. Ends as soon as the offset is certain, at the latest after 60 s of data. Unreadable data
/// end it too; the run itself reports them.
/// @param R_imu_lidar_assumed that is judged
/// @param go_on receives the fraction of the data processed (0..1); false ends the search
[[nodiscard]] Turning study_turning_of(const VehicleJob& job,
                                       const geometry::Mat3& R_imu_lidar_assumed,
                                       Executor& executor, bool read_ahead,
                                       const std::function<bool(double fraction)>& go_on);

/// D12, for the summary and run.log.
[[nodiscard]] Finding time_offset_finding(const LidarTimeOffset& offset, const InputReport& report);

}  // namespace rali::drive
