#pragma once

#include <functional>

#include "rali/scenario/recording/write_recording.hpp"
#include "rali/sim/fleet/closed_loop.hpp"

namespace rali::cli {

/// Lets `software` drive a simulation, and records it as write_recording() does. A signal or a
/// failed write of the recording ends the mission. Faults of `options` reach the software, too.
/// @param each  called before each decision
/// Errors: those of write_recording(), run_closed_loop().
[[nodiscard]] Result<scenario::RecordingSummary> record_mission(
    sim::FleetSimulation& sim, const scenario::RecordingOptions& options,
    sim::FleetSoftware& software, double time_limit_s,
    const std::function<void(Time)>& each = [](Time) {});

}  // namespace rali::cli
