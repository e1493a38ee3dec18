#pragma once

#include <functional>
#include <string>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::cli {

/// What write_demo_recording() leaves in its folder.
struct DemoRecording {
  std::string fleet_file;  ///< input of rali map
  eval::PoseList truth;    ///< T_world_body at the end of each sweep
  double duration_s = 0.0;
};

/// Told how far the simulation is, 0 to 1; false ends it.
using DemoProgress = std::function<bool(double share)>;

/// Simulates one vehicle and writes what a user would have: v1.mcap (ROS 2 messages as a
/// Velodyne driver sends them, an IMU turned and beside the body), fleet.yaml with the calibration
/// as measured by hand, and truth/v1.tum. Same options, same bytes.
/// Errors: kUsage (options), kMachine (disk), kInterrupted.
[[nodiscard]] Result<DemoRecording> write_demo_recording(const sim::SimOptions& options,
                                                         const std::string& folder,
                                                         const DemoProgress& progress);

}  // namespace rali::cli
