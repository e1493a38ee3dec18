#pragma once

#include <string>

#include "rali/cli/session.hpp"
#include "rali/scenario/recording/write_recording.hpp"

namespace rali::cli {

struct LiveWorldJob {
  double rate = 1.0;          ///< simulated seconds per second of real time
  double time_limit_s = 0.0;  ///< of simulated time
  int ros_domain = 0;
  std::string ros_interface = "lo";  ///< name or address of the network
};

/// A simulated world that runs in real time and communicates by ROS 2 only. It first writes
/// live.yaml and the fleet's key for `rali run`, and waits until every LiDAR has a subscriber. Then
/// it records the published data as write_recording() does, with the ground truth.
/// Errors: those of write_recording(), run_closed_loop(), open_dds_ros_bus().
[[nodiscard]] Result<scenario::RecordingSummary> run_live_world_job(
    sim::FleetSimulation& sim, const scenario::RecordingOptions& options, const LiveWorldJob& job,
    Session& session);

}  // namespace rali::cli
