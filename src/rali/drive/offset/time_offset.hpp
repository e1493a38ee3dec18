#pragma once

#include <functional>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/imu/rotation_study.hpp"

namespace rali::drive {

/// Judges what turning told about the time offset between LiDAR and IMU. It is taken where it is
/// certain (sigma at most kOffsetSigmaMax_s, not at the border of the search) and significant
/// (beyond kOffsetLeast_s and four sigma); else the offset is 0 and `origin` says why.
/// @param looked_at_s length of the data behind the study, for the words [s]
[[nodiscard]] LidarTimeOffset judge_time_offset(const imu::RotationStudy& study,
                                                double looked_at_s);

inline constexpr double kOffsetLeast_s = 0.010;
inline constexpr double kOffsetSigmaMax_s = 0.010;

/// `lidar.time_offset_s: auto`: plays the beginning of a vehicle's input, compares the turning of a
/// LiDAR odometry with the gyro's and judges the offset. Ends as soon as the answer is certain, at
/// the latest after 60 s of data. What cannot be read ends it too: the run itself tells of that.
/// @param go_on told the share of the data looked at (0..1); false ends the search
[[nodiscard]] LidarTimeOffset estimate_time_offset(const VehicleJob& job, Executor& executor,
                                                   bool read_ahead,
                                                   const std::function<bool(double share)>& go_on);

/// D12, for the summary and run.log.
[[nodiscard]] Finding time_offset_finding(const LidarTimeOffset& offset, const InputReport& report);

}  // namespace rali::drive
