#pragma once

#include <atomic>
#include <optional>

#include "rali/base/executor.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

/// How the events of one vehicle came to their end.
struct LoopEnd {
  bool interrupted = false;    ///< by `stop`
  std::optional<Error> error;  ///< unreadable input or a full disk; what came before is whole
};

/// Feeds a vehicle with all events of a source and hands what follows to `run`.
/// @param read_ahead decode on a second thread; the results are the same
/// @param findings of the vehicle, in the order in which they came up; also told to `sink`
/// @param strict a diverged pose ends the events
[[nodiscard]] LoopEnd run_events(ReportedSource& source, bool read_ahead, bool strict,
                                 vehicle::Vehicle& vehicle, Executor& executor, VehicleRun& run,
                                 FindingList& findings, ProgressSink& sink,
                                 const std::atomic<bool>& stop);

}  // namespace rali::drive
