#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/time.hpp"
#include "rali/drive/fleet_loop.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// Vehicles step in parallel through slices of this much data time. What a vehicle reports reaches
/// the others with the next slice, as if the message took that long. A slice holds about one scan
/// of each vehicle, so that no vehicle waits long for another.
inline constexpr Duration kSlice = Duration::from_ns(100'000'000);

/// One event of a slice, and its outputs.
struct SliceStep {
  std::size_t vehicle = 0;
  vehicle::Event event;
  vehicle::OutputList outputs = {};  ///< if done
  bool done = false;                 ///< false if the vehicle's events had already ended
  bool last = false;                 ///< the last event of the vehicle
};

/// Steps each vehicle through its events of a slice, in their order; different vehicles on
/// different threads. A vehicle's events end with EndOfData or, if `strict`, with the first
/// diverged pose: EndOfData then follows in the same step.
/// @param ended by vehicle: those get no events
void run_slice(std::span<const FleetMember> members, const std::vector<bool>& ended, bool strict,
               Executor& executor, std::vector<SliceStep>& steps);

}  // namespace rali::drive
