#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/cli/session.hpp"
#include "rali/drive/closed_loop/fleet_software.hpp"
#include "rali/scenario/recording/write_recording.hpp"

namespace rali::cli {

/// Result of a mission driven by the fleet's own software.
struct ClosedLoopRun {
  scenario::RecordingSummary recording;
  drive::MissionLog mission;
};

/// Lets the fleet's software drive a simulation, records it as write_recording() does, and writes
/// rounds.csv, frontiers.csv and traffic.csv next to it. The software is configured by fleet.yaml.
/// @param assignments KEY=VALUE for keys of is_mission_key(), for the software and its radio
/// @param time_limit_s of the mission
/// Errors: those of write_recording(), run_closed_loop().
[[nodiscard]] Result<ClosedLoopRun> run_closed_loop_job(sim::FleetSimulation& sim,
                                                        const scenario::RecordingOptions& options,
                                                        const std::vector<std::string>& assignments,
                                                        double time_limit_s, Executor& executor,
                                                        Session& session);

/// True for keys of fleet.yaml's `settings.`, of the radio link (`link.`), and of the simulated
/// onboard computers (`sim.`).
[[nodiscard]] bool is_mission_key(std::string_view assignment);

/// Checks such assignments before anything is simulated or written. Returns the notices about keys
/// with old names. Errors (kUsage): unknown key, value not allowed.
[[nodiscard]] Result<std::vector<std::string>> check_mission_settings(
    const std::vector<std::string>& assignments);

/// "12 rounds, all explored" and the like, one sentence per line.
[[nodiscard]] std::string mission_text(const drive::MissionLog& mission, double duration_s);

}  // namespace rali::cli
