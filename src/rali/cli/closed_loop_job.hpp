#pragma once

#include <string>
#include <string_view>
#include <vector>

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
/// rounds.csv, frontiers.csv and traffic.csv beside it. The software knows what fleet.yaml tells.
/// @param assignments KEY=VALUE of what is_mission_key() names, for the software and its radio
/// @param time_limit_s of the mission
/// Errors: those of write_recording(), run_closed_loop().
[[nodiscard]] Result<ClosedLoopRun> run_closed_loop_job(sim::FleetSimulation& sim,
                                                        const scenario::RecordingOptions& options,
                                                        const std::vector<std::string>& assignments,
                                                        double time_limit_s, Executor& executor,
                                                        Session& session);

/// `settings.` of fleet.yaml, `link.` of the radio that brings the software's messages, or `sim.`
/// of the computers that it runs on.
[[nodiscard]] bool is_mission_key(std::string_view assignment);

/// Whether such assignments can be obeyed, before anything is simulated or written: the notices
/// about keys with an old name. Errors (kUsage): unknown key, value not allowed.
[[nodiscard]] Result<std::vector<std::string>> check_mission_settings(
    const std::vector<std::string>& assignments);

/// "12 rounds, all explored" and the like, one sentence per line.
[[nodiscard]] std::string mission_text(const drive::MissionLog& mission, double duration_s);

}  // namespace rali::cli
