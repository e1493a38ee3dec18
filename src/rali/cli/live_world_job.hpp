#pragma once

#include "rali/cli/session.hpp"
#include "rali/scenario/recording/write_recording.hpp"

namespace rali::cli {

struct LiveWorldJob {
  double rate = 1.0;          ///< seconds of the world in one second of this machine
  double time_limit_s = 0.0;  ///< of the world
  int ros_domain = 0;
};

/// A world that runs in real time and speaks ROS 2 only. Writes live.yaml and the fleet's key for
/// `rali run` first, waits until every LiDAR has a listener, then records what it sends as
/// write_recording() does, with the truth.
/// Errors: those of write_recording(), run_closed_loop(), open_dds_ros_bus().
[[nodiscard]] Result<scenario::RecordingSummary> run_live_world_job(
    sim::FleetSimulation& sim, const scenario::RecordingOptions& options, const LiveWorldJob& job,
    Session& session);

}  // namespace rali::cli
