#pragma once

#include <string>

#include "rali/cli/session.hpp"
#include "rali/drive/closed_loop/fleet_software.hpp"
#include "rali/scenario/recording/write_recording.hpp"

namespace rali::cli {

/// What came of a mission that the fleet drove itself.
struct ClosedLoopRun {
  scenario::RecordingSummary recording;
  drive::MissionLog mission;
};

/// Lets the fleet's software drive a simulation, records it as write_recording() does, and writes
/// rounds.csv and frontiers.csv beside it. The software knows what fleet.yaml tells.
/// @param time_limit_s of the mission
/// Errors: those of write_recording(), run_closed_loop().
[[nodiscard]] Result<ClosedLoopRun> run_closed_loop_job(sim::FleetSimulation& sim,
                                                        const scenario::RecordingOptions& options,
                                                        double time_limit_s, Executor& executor,
                                                        Session& session);

/// "12 rounds, all explored" and the like, one sentence per line.
[[nodiscard]] std::string mission_text(const drive::MissionLog& mission, double duration_s);

}  // namespace rali::cli
