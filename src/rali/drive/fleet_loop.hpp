#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/ranges/range_log.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// How the events of one vehicle came to their end.
struct LoopEnd {
  bool interrupted = false;    ///< by `stop`
  std::optional<Error> error;  ///< unreadable input or a full disk; earlier results are complete
};

/// One vehicle of a fleet; its number is its index in the fleet.
struct FleetMember {
  ReportedSource* source = nullptr;
  /// vehicle::Vehicle::step
  std::function<void(const vehicle::Event&, Executor&, vehicle::OutputList&)> step;
  VehicleRun* run = nullptr;
  FindingList findings;  ///< of the vehicle, in the order of occurrence
  LoopEnd end;
};

struct FleetLoopOptions {
  bool read_ahead = false;  ///< decode on a thread per vehicle; the results are the same
  bool strict = false;      ///< a diverged pose ends the events of its vehicle
  bool separate = false;    ///< the vehicles share no clock: no ranges and no messages between them
};

/// The live map; may be null.
class LiveMap;

/// Feeds all vehicles with their events and their ranges in slices of data time (fleet_slice.hpp).
/// The next event is the oldest over all sources (at equal times inertial samples before ranges
/// before scans, then by vehicle number). Outputs are taken in the same order. After each pose of a
/// vehicle the others receive its peer state with the next slice. A vehicle whose data has ended or
/// failed is no longer waited for; a full disk ends all.
/// @param ranges of files, by time; those of topics come from the sources
/// @param log receives every range, and how the vehicles used it
void run_fleet(std::span<FleetMember> members, std::span<const sensor::RangeSample> ranges,
               const RangeOptions& range_options, const FleetLoopOptions& options,
               Executor& executor, RangeLog& log, LiveMap* live, ProgressSink& sink,
               const std::atomic<bool>& stop);

}  // namespace rali::drive
